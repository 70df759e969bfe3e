// What FixStartState leaves for PrependEscape. PlanningPipeline::generatePlan calls the request adapters, the planners
// and the response adapters one after the other in one thread, with one planning scene (planning_pipeline.cpp,
// MoveIt 2.12): a variable of the thread is enough. The response adapter gets the request as the request adapters left
// it, so the start from before is nowhere else.
#pragma once

#include <extricate_moveit.hpp>

namespace planning_scene {
class PlanningScene;
}

namespace extricate_moveit {

struct MovedStart {
    /// The scene of the request; null if no start was moved.
    const planning_scene::PlanningScene* scene = nullptr;
    extricate::moveit::FixedStart fixed;
};

inline MovedStart& moved_start() {
    static thread_local MovedStart moved;
    return moved;
}

}  // namespace extricate_moveit
