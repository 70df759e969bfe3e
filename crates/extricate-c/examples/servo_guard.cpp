// A guard beside a controller of 1 kHz: which way is out, and is there time to say so? A motion runs through
// obstacles; each frame is one query of a stream with a budget.
//
// usage: servo_guard [SCENE [FRAMES]]
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include <extricate.hpp>

int main(int argc, char** argv) {
    const extricate::Scene scene = argc > 1 ? extricate::Scene(argv[1]) : extricate::Scene::builtin("shelf-arm");
    const int frames = argc > 2 ? std::atoi(argv[2]) : 2000;
    if (frames < 1) return std::fputs("FRAMES: expected 1 or more\n", stderr), 2;
    const std::size_t nq = scene.nq();

    // The budget leaves the rest of a millisecond to the controller.
    extricate::Options options;
    options.effort = extricate::Effort::quick;
    options.max_seconds = 0.0007;
    extricate::StreamOptions steady;
    steady.hysteresis = 0.1;  // directions do not flip between exits that are about as near
    extricate::Solver(scene, options).warm_up();
    extricate::Stream stream(scene, options, steady);

    // From one colliding configuration to another, there and back.
    const std::vector<double> ends = scene.sample(2, extricate::Sample::colliding, 1);
    std::vector<double> q(nq);
    int in_time = 0, colliding = 0;
    for (int frame = 0; frame < frames; ++frame) {
        const double at = 0.5 - 0.5 * std::cos(6.283185307179586 * frame / frames);
        for (std::size_t k = 0; k < nq; ++k) q[k] = (1 - at) * ends[k] + at * ends[nq + k];
        const auto began = std::chrono::steady_clock::now();
        const auto answer = stream.query(q);
        const std::chrono::duration<double> took = std::chrono::steady_clock::now() - began;
        in_time += took.count() <= 1e-3;
        if (!answer || answer->is_free()) continue;
        ++colliding;
        if (frame % (frames / 10 + 1) != 0) continue;
        // The way out: the controller moves against the gradient of the depth.
        std::printf("frame %4d, %.3f from free, way out:", frame, answer->depth());
        for (double slope : answer->gradient()) std::printf(" %+.2f", -slope);
        std::printf("\n");
    }
    std::printf("%d frames, %d in collision, %.1f %% answered within 1 ms\n", frames, colliding, 100.0 * in_time / frames);
}
