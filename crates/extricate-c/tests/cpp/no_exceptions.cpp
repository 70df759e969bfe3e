// The same header without exceptions: what fails gives an empty object, and says why.
#include <extricate.hpp>

#include <cstdio>

int main() {
    const extricate::Scene none("none.toml");
    bool passed = !none && extricate::last_status() == EXTRICATE_FILE;
    passed = passed && extricate::last_error().find("none.toml") != std::string::npos;

    const extricate::Scene scene = extricate::Scene::builtin("planar-arm");
    extricate::Solver solver(scene);
    passed = passed && scene && solver && extricate::last_status() == EXTRICATE_OK;
    passed = passed && !solver.query({0.0}) && extricate::last_status() == EXTRICATE_CONFIGURATION;
    passed = passed && solver.query({0.4, 0.0, 0.0}).depth() > 0;
    passed = passed && !extricate::Solver(none) && extricate::last_status() == EXTRICATE_ARGUMENT;
    if (!passed) std::fprintf(stderr, "status %d: %s\n", extricate::last_status(), extricate::last_error().c_str());
    return passed ? 0 : 1;
}
