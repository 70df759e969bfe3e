//! Distances between configurations and their embeddings.
