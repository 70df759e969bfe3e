"""Our side: answers the queries of a scene on one thread, with a model and without."""
import re

import programs
from sides import BUILD

# The nearest stored sample alone, and refinement with numbers of starts.
NEAREST = "samples alone (`nearest`)"
METHODS = {NEAREST: "nearest"}
METHODS |= {f"`refined`, {k} start{'s' * (k > 1)}": k for k in (1, 2, 4, 8)}
# The default takes as many starts as the degrees of freedom require, and more if they find exits.
DEFAULT = "`refined`"
METHODS |= {DEFAULT: "refined", "`refined`, 16 starts": 16, "`exhaustive`": "exhaustive"}
# The scene without a model, and with a model of the robot alone.
NO_MODEL, ROBOTS_MODEL = "`refined`, no model", "`refined`, robot's model"
METHODS |= {NO_MODEL: "refined", ROBOTS_MODEL: "refined"}
ROBOT_LABELS = 20_000


class Ours:
    """A model of one scene, learned when this is made."""

    def __init__(self, name, path, labels):
        self.scene, alone = path, path.with_name(f"{name}-alone.toml")
        alone.write_text("".join(entry for entry in re.split(r"(?m)^(?=\[)", path.read_text()) if not entry.startswith("[[obstacle]]")))
        self.robots_model = BUILD / f"{name}-alone.model"
        programs.learn(alone, self.robots_model, ROBOT_LABELS)
        self.model = BUILD / f"{name}.model"
        learned = programs.learn(path, self.model, labels)
        self.learning = {
            "labels": learned["statistics"]["labels"],
            "samples": learned["statistics"]["boundary_samples"],
            "seconds": learned["seconds"],
            "cpu_seconds": learned["cpu_seconds"],
        }

    def answers(self, method, queries):
        if method == NO_MODEL:
            return programs.answers(self.scene, queries, METHODS[method])
        if method == ROBOTS_MODEL:
            return programs.answers(self.robots_model, queries, METHODS[method], "--scene", self.scene)
        return programs.answers(self.model, queries, METHODS[method])
