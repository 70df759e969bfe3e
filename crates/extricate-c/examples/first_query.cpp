// The nearest free configuration of a scene that comes with the library, and what is known about it.
#include <cstdio>

#include <extricate.hpp>

int main() {
    const extricate::Scene scene = extricate::Scene::builtin("shelf-arm");
    extricate::Solver solver(scene);
    const std::vector<double> q = {2.3, -1.7, 0.0, 0.7, 0.0, 2.0, 0.0};

    const std::optional<extricate::Answer> answer = solver.query(q);
    if (!answer) return std::puts("nothing is free"), 1;
    std::printf("%.6f away, at least %.6f; nothing moves by more than %.3f m\n", answer->depth(), answer->lower_bound(),
                answer->max_displacement());
    for (const ExtricatePair& pair : answer->colliding()) {
        const auto [first, second] = scene.names(pair);
        std::printf("%s collides with %s\n", first.c_str(), second.c_str());
    }

    // An obstacle comes: what is prepared of the rest is shared.
    const extricate::Scene changed = scene.with_obstacles({{"ball", extricate::Shape::sphere(0.1), {0.4, 0.0, 0.6}}});
    extricate::Solver there(changed);
    std::printf("free with the ball: %s\n", there.check(answer->witness()) ? "yes" : "no");
}
