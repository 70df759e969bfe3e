// What FixStartState leaves for PrependEscape. PlanningPipeline::generatePlan calls the request adapters, the planners
// and the response adapters one after the other in one thread, with one planning scene (planning_pipeline.cpp,
// MoveIt 2.12): a variable of the thread is enough. The response adapter gets the request as the request adapters left
// it, so the start from before is nowhere else.
#pragma once

#include <memory>
#include <utility>

#include <extricate_moveit.hpp>

namespace planning_scene {
class PlanningScene;
}

namespace extricate_moveit {

struct MovedStart {
    /// The scene of the request; empty if no start was moved. A scene that is made later is another one, even if it
    /// has the same address.
    std::weak_ptr<const planning_scene::PlanningScene> scene;
    extricate::moveit::FixedStart fixed;

    bool is_in(const std::shared_ptr<const planning_scene::PlanningScene>& other) const {
        return !scene.owner_before(other) && !other.owner_before(scene);
    }
};

inline MovedStart& moved_start() {
    static thread_local MovedStart moved;
    return moved;
}

}  // namespace extricate_moveit
