//! Penetration depth of two overlapping convex shapes (expanding polytope algorithm).
