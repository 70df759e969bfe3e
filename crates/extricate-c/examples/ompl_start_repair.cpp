// OMPL with extricate: the exact checker decides what is valid, motions are proved free, a sampler
// gives valid states beside obstacles, and starts in collision are repaired before planning.
//
// The classes are written to be copied. usage: ompl_start_repair [SCENE [COUNT]]
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <vector>

#include <ompl/base/MotionValidator.h>
#include <ompl/base/StateValidityChecker.h>
#include <ompl/base/ValidStateSampler.h>
#include <ompl/base/spaces/RealVectorStateSpace.h>
#include <ompl/geometric/SimpleSetup.h>
#include <ompl/geometric/planners/rrt/RRTConnect.h>
#include <ompl/util/Console.h>
#include <ompl/util/RandomNumbers.h>

#include <extricate.hpp>

namespace ob = ompl::base;
namespace og = ompl::geometric;

/// The numbers of a state of a space of real vectors.
extricate::Config values(const ob::State* state, const extricate::Solver& solver) {
    return {state->as<ob::RealVectorStateSpace::StateType>()->values, solver.scene().nq()};
}

/// Valid is what the exact checker calls free. OMPL may ask from any thread.
class Validity : public ob::StateValidityChecker {
public:
    Validity(const ob::SpaceInformationPtr& si, const extricate::Scene& scene) : ob::StateValidityChecker(si), solver_(scene) {}
    bool isValid(const ob::State* state) const override { return solver_.check(values(state, solver_)); }
    double clearance(const ob::State* state) const override { return solver_.distance(values(state, solver_)); }

private:
    extricate::Solver solver_;
};

/// A motion is valid if all of it is proved free: there is no resolution to choose.
class Motions : public ob::MotionValidator {
public:
    Motions(const ob::SpaceInformationPtr& si, const extricate::Scene& scene) : ob::MotionValidator(si), solver_(scene) {}
    bool checkMotion(const ob::State* from, const ob::State* to) const override {
        const bool valid = segment(from, to).is_free;
        ++(valid ? valid_ : invalid_);
        return valid;
    }
    bool checkMotion(const ob::State* from, const ob::State* to, std::pair<ob::State*, double>& last) const override {
        const ExtricateSegment found = segment(from, to);
        ++(found.is_free ? valid_ : invalid_);
        if (found.is_free) return true;
        last.second = found.free_until;
        if (last.first) si_->getStateSpace()->interpolate(from, to, last.second, last.first);
        return false;
    }

private:
    ExtricateSegment segment(const ob::State* from, const ob::State* to) const {
        return solver_.check_segment(values(from, solver_), values(to, solver_));
    }
    extricate::Solver solver_;
};

/// Repaired states keep a little more than the scene asks for: from a state that just keeps its
/// clearance, no motion can be proved free.
extricate::Options with_room() {
    extricate::Options options;
    options.clearance = 0.002;
    return options;
}

/// Samples that collide are moved to the nearest free configuration: they lie beside obstacles,
/// where narrow passages begin.
class Sampler : public ob::ValidStateSampler {
public:
    Sampler(const ob::SpaceInformation* si, const extricate::Scene& scene)
        : ob::ValidStateSampler(si), solver_(scene, with_room()), sampler_(si->allocStateSampler()) {}
    bool sample(ob::State* state) override {
        sampler_->sampleUniform(state);
        return repair(state);
    }
    bool sampleNear(ob::State* state, const ob::State* near, double distance) override {
        sampler_->sampleUniformNear(state, near, distance);
        return repair(state);
    }
    /// Moves a state to the nearest free one.
    bool repair(ob::State* state) {
        const std::optional<extricate::Answer> answer = solver_.query(values(state, solver_));
        if (!answer) return false;
        double* numbers = state->as<ob::RealVectorStateSpace::StateType>()->values;
        std::copy(answer->witness().begin(), answer->witness().end(), numbers);
        return true;
    }

private:
    extricate::Solver solver_;
    ob::StateSamplerPtr sampler_;
};

int main(int argc, char** argv) {
    ompl::msg::setLogLevel(ompl::msg::LOG_WARN);
    ompl::RNG::setSeed(1);
    const extricate::Scene scene = argc > 1 ? extricate::Scene(argv[1]) : extricate::Scene::builtin("shelf-arm");
    const int wanted = argc > 2 ? std::atoi(argv[2]) : 100;
    const std::size_t nq = scene.nq();

    auto space = std::make_shared<ob::RealVectorStateSpace>(static_cast<unsigned>(nq));
    const auto [lower, upper] = scene.limits();
    ob::RealVectorBounds bounds(static_cast<unsigned>(nq));
    bounds.low = lower;
    bounds.high = upper;
    space->setBounds(bounds);

    og::SimpleSetup setup(space);
    const ob::SpaceInformationPtr& si = setup.getSpaceInformation();
    setup.setStateValidityChecker(std::make_shared<Validity>(si, scene));
    si->setMotionValidator(std::make_shared<Motions>(si, scene));
    si->setValidStateSamplerAllocator([&](const ob::SpaceInformation* info) { return std::make_shared<Sampler>(info, scene); });
    si->setup();

    // Starts in collision, as random states are, until there are enough.
    Sampler sampler(si.get(), scene);
    const ob::StateSamplerPtr uniform = si->allocStateSampler();
    int colliding = 0, repaired = 0;
    double farthest = 0;
    ob::ScopedState<> start(space), goal(space);
    while (colliding < wanted) {
        uniform->sampleUniform(start.get());
        if (si->isValid(start.get())) continue;
        ++colliding;
        const ob::ScopedState<> before = start;
        if (!sampler.repair(start.get()) || !si->isValid(start.get())) continue;
        ++repaired;
        farthest = std::max(farthest, si->distance(before.get(), start.get()));
    }
    std::printf("repaired %d of %d starts, the farthest by %.3f rad\n", repaired, colliding, farthest);

    // The last of them is planned from, toward a state that the sampler gives.
    const ob::ValidStateSamplerPtr valid = si->allocValidStateSampler();
    const bool has_goal = valid->sample(goal.get());
    setup.setStartAndGoalStates(start, goal);
    setup.setPlanner(std::make_shared<og::RRTConnect>(si));
    const ob::PlannerStatus solved = setup.solve(10.0);
    const bool is_exact = has_goal && solved == ob::PlannerStatus::EXACT_SOLUTION;
    std::printf("planned from it: %s\n", is_exact ? "yes" : "no");
    return repaired == wanted && is_exact ? 0 : 1;
}
