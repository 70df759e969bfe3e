"""Our side: the answers of a model to the queries of a scene, one thread."""
import programs
from sides import BUILD

# The nearest stored sample alone, as published, and what refinement makes of it.
NEAREST = "samples alone (`nearest`)"
METHODS = {NEAREST: "nearest"}
METHODS |= {f"`refined`, {k} start{'s' * (k > 1)}": k for k in (1, 2, 4, 8)}
# The default takes as many starts as were calibrated when the scene was learned, more where they find something.
DEFAULT = "`refined`"
METHODS |= {DEFAULT: "refined", "`refined`, 16 starts": 16, "`exhaustive`": "exhaustive"}


class Ours:
    """A model of one scene, learned when this is made."""

    def __init__(self, name, path, labels):
        self.model = BUILD / f"{name}.model"
        learned = programs.learn(path, self.model, labels)
        self.learning = {
            "labels": learned["statistics"]["labels"],
            "samples": learned["statistics"]["boundary_samples"],
            "seconds": learned["seconds"],
            "cpu_seconds": learned["cpu_seconds"],
        }

    def answers(self, method, queries):
        return programs.answers(self.model, queries, METHODS[method])
