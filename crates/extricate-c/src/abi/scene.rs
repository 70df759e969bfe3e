//! Functions that load and build scenes, and learn and save models.

#![allow(unsafe_code)]

use std::ffi::{c_char, c_void};
use std::fs::File;
use std::io::Read;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use extricate::entries::{assemble_scene, parse};
use extricate::files::{check_model_output, check_regular};
use extricate::{
    LearnOptions, LearnProgress, LoadOptions, Model, Scene, Solver, builtin, load_model, load_scene_with, save_model,
};

use super::handles::ExtricateScene;
use super::types::{ExtricateLoadOptions, ExtricateProgress, ExtricateStatus, ExtricateText};
use crate::load_options;
use crate::options::{of_call, threads as thread_count};
use crate::raw::{self, Listener};
use crate::status::{Fault, Result, guarded};

/// Loads a scene file (TOML), a URDF as a scene of that robot alone, or a model file as the learned
/// scene with its model. Null options mean the defaults; they do not apply to a model.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_load(
    path: *const c_char,
    options: *const ExtricateLoadOptions,
    scene: *mut *mut ExtricateScene,
) -> ExtricateStatus {
    // SAFETY: the contract of this module.
    let (path, scene) = unsafe { (raw::text(path, "path"), raw::place(scene, "scene")) };
    guarded(|| {
        let (path, scene) = (path?, scene?);
        // SAFETY: the same.
        let options = unsafe { load_options::read(options) }?;
        scene.hand_over(ExtricateScene::new(load(Path::new(path), &options)?));
        Ok(())
    })
}

/// Makes a scene from the text of a scene file (TOML) or of a URDF, without a file.
///
/// Relative paths in the text start from `folder`; null means the working directory. If `texts`
/// contains a path of the text, its content replaces that file, so a URDF in memory needs no file
/// either. Meshes are read from files.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_scene_from_text(
    text: *const c_char,
    folder: *const c_char,
    texts: *const ExtricateText,
    text_count: usize,
    scene: *mut *mut ExtricateScene,
) -> ExtricateStatus {
    // SAFETY: the contract of this module.
    let (text, folder) = unsafe { (raw::text(text, "text"), raw::optional_text(folder, "folder")) };
    // SAFETY: the same.
    let (texts, scene) = unsafe { (named_texts(texts, text_count), raw::place(scene, "scene")) };
    guarded(|| {
        let (text, folder, texts, scene) = (text?, folder?, texts?, scene?);
        let made = of_text(text, Path::new(folder.unwrap_or_default()), &texts)?;
        scene.hand_over(ExtricateScene::new(Solver::new(made)));
        Ok(())
    })
}

/// Makes one of the scenes that come with the library, such as "shelf-arm" or "planar-arm".
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_scene_builtin(
    name: *const c_char,
    scene: *mut *mut ExtricateScene,
) -> ExtricateStatus {
    // SAFETY: the contract of this module.
    let (name, scene) = unsafe { (raw::text(name, "name"), raw::place(scene, "scene")) };
    guarded(|| {
        let (name, scene) = (name?, scene?);
        scene.hand_over(ExtricateScene::new(Solver::new(builtin::scene(name)?)));
        Ok(())
    })
}

/// Learns a model of the scene: stored samples, which are additional starts of queries. Learning
/// takes seconds for most robots. Writes the same scene with the model to `model`.
///
/// `labels` is the number of exact checks to spend, 0 for the default. `seconds` limits the time;
/// it is more than 0, and infinity means no limit. `threads` is 0 for one per core. The model
/// depends only on scene, labels and seed, unless the time limit ended learning.
///
/// `progress` is null, or a function that is called after each step, on any thread. It gets the
/// state of the run and `progress_data`. If it returns false, the run ends and keeps what it has
/// learned. It must not throw.
#[unsafe(no_mangle)]
#[allow(clippy::too_many_arguments)]
pub unsafe extern "C" fn extricate_learn(
    scene: *const ExtricateScene,
    labels: usize,
    seconds: f64,
    seed: u64,
    threads: usize,
    progress: Option<unsafe extern "C" fn(*const ExtricateProgress, *mut c_void) -> bool>,
    progress_data: *mut c_void,
    model: *mut *mut ExtricateScene,
) -> ExtricateStatus {
    // SAFETY: the contract of this module.
    let (scene, model) = unsafe { (raw::shared(scene, "scene"), raw::place(model, "model")) };
    guarded(|| {
        let (scene, model) = (scene?, model?);
        let mut options = LearnOptions::default().seed(seed).threads(thread_count(threads)?);
        options.labels = if labels == 0 { options.labels } else { labels };
        options.seconds = (seconds != f64::INFINITY).then_some(seconds);
        // SAFETY: the header states the contract for `progress`.
        let listener = progress.map(|progress| unsafe { Listener::new(progress, progress_data) });
        let mut tell = |state: &LearnProgress| match listener.is_none_or(|listener| listener.tell(&progress_of(state)))
        {
            true => ControlFlow::Continue(()),
            false => ControlFlow::Break(()),
        };
        let learned = Model::learn_with(Scene::clone(scene.scene()), &options, &mut tell).map_err(of_call)?;
        model.hand_over(ExtricateScene::new(Solver::of_model(learned)));
        Ok(())
    })
}

fn progress_of(state: &LearnProgress) -> ExtricateProgress {
    let stages = [c"exploring", c"training", c"tracing the boundary", c"solving", c"measuring"];
    let stage = stages.iter().find(|stage| stage.to_bytes() == state.stage.as_bytes()).copied().unwrap_or(c"");
    ExtricateProgress {
        stage: stage.as_ptr(),
        fraction: state.fraction,
        labels: state.labels,
        boundary_samples: state.boundary_samples,
        accuracy: state.accuracy.unwrap_or(f64::NAN),
    }
}

/// Writes a learned model to a file; extricate_load() reads it.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_save(model: *const ExtricateScene, path: *const c_char) -> ExtricateStatus {
    // SAFETY: the contract of this module.
    let (model, path) = unsafe { (raw::shared(model, "model"), raw::text(path, "path")) };
    guarded(|| {
        let (model, path) = (model?, Path::new(path?));
        let nothing = || Fault::argument("model: got a scene of which nothing was learned, expected a learned model");
        let learned = model.solver.model().filter(|_| model.solver.is_learned()).ok_or_else(nothing)?;
        check_model_output(path)?;
        Ok(save_model(learned, path)?)
    })
}

/// Prepares the scene for queries. Without this call, the first query or check does it. Preparation
/// takes milliseconds to seconds, the longest for meshes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_scene_prepare(scene: *const ExtricateScene) -> ExtricateStatus {
    // SAFETY: the contract of this module.
    let scene = unsafe { raw::shared(scene, "scene") };
    guarded(|| {
        scene?.solver.prepare();
        Ok(())
    })
}

/// Frees a scene; solvers, streams and answers that were made from it stay valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_scene_free(scene: *mut ExtricateScene) {
    guarded(|| {
        // SAFETY: the contract of this module.
        unsafe { raw::take_back(scene) };
        Ok(())
    });
}

/// # Safety
/// The contract of [`crate::raw`].
unsafe fn named_texts<'a>(texts: *const ExtricateText, count: usize) -> Result<Vec<(&'a str, &'a str)>> {
    // SAFETY: the contract of this function.
    let texts = unsafe { raw::slice(texts, count, "texts") }?;
    let named = |(at, given): (usize, &ExtricateText)| {
        // SAFETY: the same.
        let path = unsafe { raw::text(given.path, &format!("texts[{at}].path")) }?;
        // SAFETY: the same.
        Ok((path, unsafe { raw::text(given.text, &format!("texts[{at}].text")) }?))
    };
    texts.iter().enumerate().map(named).collect()
}

/// Bytes at the start of a file that suffice to recognise a model.
const HEAD_BYTES: u64 = 4096;

/// Loads a scene file, a URDF or a model file.
fn load(path: &Path, options: &LoadOptions) -> Result<Solver> {
    let mut head = Vec::new();
    // An unreadable file, or a pipe, on which opening would wait, leaves the head empty: the
    // library refuses it below, with its own message.
    if let Ok(file) = check_regular(path).and_then(|_| File::open(path)) {
        let _ = file.take(HEAD_BYTES).read_to_end(&mut head);
    }
    Ok(if Model::is_model(&head) {
        Solver::of_model(load_model(path)?)
    } else {
        Solver::new(load_scene_with(path, options)?)
    })
}

/// Name in messages of a scene without a file.
const NAME: &str = "scene";
/// Name in messages of a URDF without a file.
const URDF: &str = "robot.urdf";

fn of_text(text: &str, folder: &Path, texts: &[(&str, &str)]) -> Result<Scene> {
    let path = |name: &str| folder.join(name).display().to_string();
    let mut known: Vec<(String, String)> = texts.iter().map(|(at, text)| (path(at), text.to_string())).collect();
    let is_urdf = text.trim_start_matches('\u{feff}').trim_start().starts_with('<');
    let entries = if is_urdf {
        known.push((path(URDF), text.to_string()));
        format!("[[robot]]\nurdf = \"{URDF}\"\n")
    } else {
        text.to_string()
    };
    let name: PathBuf = folder.join(NAME);
    Ok(assemble_scene(&name.display().to_string(), &parse(NAME, &entries)?, &known)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    const ROBOT: &str = "<robot name='r'><link name='a'/><link name='b'><collision><geometry><sphere radius='0.1'/>\
         </geometry></collision></link><joint name='j' type='prismatic'><parent link='a'/><child link='b'/>\
         <axis xyz='1 0 0'/><limit lower='0' upper='9' effort='1' velocity='1'/></joint></robot>";

    #[test]
    fn texts_stand_for_files() {
        let alone = of_text(ROBOT, Path::new(""), &[]).unwrap();
        assert_eq!(alone.space().nq(), 1);
        let scene = "[[robot]]\nurdf = 'arm.urdf'\n[[obstacle]]\nname = 'box'\nshape = { box = [1, 1, 1] }";
        let both = of_text(scene, Path::new("some/folder"), &[("arm.urdf", ROBOT)]).unwrap();
        assert_eq!(both.pairs().len(), 1);
        let missing = of_text(scene, Path::new("some/folder"), &[]).map(drop).unwrap_err();
        assert!(missing.message.contains("arm.urdf"), "{missing:?}");
        let wrong = of_text("[[robot]]\nurd = 'a'", Path::new(""), &[]).map(drop).unwrap_err();
        assert!(wrong.message.starts_with("scene: line 2"), "{wrong:?}");
    }

    #[test]
    fn models_and_scenes_are_told_by_their_bytes() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("arm.model");
        let options = LearnOptions::default().labels(2_000);
        let model = Model::learn(builtin::scene("planar-arm").unwrap(), &options).unwrap();
        save_model(&model, &path).unwrap();
        assert!(load(&path, &LoadOptions::default()).unwrap().is_learned());
        let missing = load(&folder.path().join("none.toml"), &LoadOptions::default()).map(drop).unwrap_err();
        assert!(missing.message.contains("none.toml"), "{missing:?}");
        assert!(load(folder.path(), &LoadOptions::default()).map(drop).unwrap_err().message.contains("directory"));
    }
}
