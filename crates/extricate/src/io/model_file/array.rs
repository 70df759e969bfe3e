//! An array of a model file.

use safetensors::tensor::Dtype;

pub struct Array {
    pub name: &'static str,
    pub dtype: Dtype,
    pub shape: Vec<usize>,
    pub bytes: Vec<u8>,
}
