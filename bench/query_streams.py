"""Compares streams with single queries on the frames of a motion: time saved, and exits missed."""
import json

import programs
import scenes
from page import number, table

# Step of a frame, as a share of the segment between two colliding configurations.
STEPS = (100, 1000)
SIDES = ("stream", "single")


def measure(options, folder):
    rows = []
    for name, scene in scenes.written().items():
        model, part = folder / f"{name}.model", folder / f"{name}.part"
        programs.learn(scene, model, options.stream_labels)
        queries = programs.sample(scene, options.segments + 1, 7)
        part.write_text("".join(json.dumps({"q": q}) + "\n" for q in queries))
        for steps in STEPS:
            walk = steps, min(options.frames or steps, steps), options.rounds
            rows.append({"scene": name, "steps": steps} | json.loads(programs.run("extricate-bench", "stream", model, part, *walk)))
            print(rows[-1], flush=True)
    return rows


def section(rows, options):
    shown = []
    for r in rows:
        for side in SIDES:
            f = r[side]
            times = [number(f[key]) for key in ("us", "us_95", "us_99", "us_max")]
            shown.append([r["scene"], f"1/{r['steps']}", f"{r['colliding']:,}", side, *times, percent(f["over_1ms"]), number(f["checks"]), percent(f["over_5pct"]), percent(f["over_1pct"])])
    head = ["scene", "step", "frames", "asked by", "time, median [us]", "95 %", "99 %", "most", "over 1 ms", "checks, mean", "more than 5 % farther than the other", "1 %"]
    walked = "walked whole" if not options.frames else f"of which the first {options.frames} frames are walked; where that is not the whole the stream begins anew at the next"
    verified = min(r["verified"] for r in rows)
    return f"## Streams\n\nMotions along the straight segments between {options.segments + 1} random colliding configurations, {walked}. Every frame is asked by a stream and by a plain query, `refined` both, in turns; those " \
           f"that collide are counted, but for the first, which a stream has to search as a query does. Models of {options.stream_labels:,} labels; processor time of one thread, of each frame the shortest of {options.rounds} " \
           f"rounds. Verified answers of streams: {percent(verified)}.\n\n{table(head, shown)}"


def percent(share):
    return "0" if share == 0 else "100 %" if share == 1 else f"{100 * share:.2g} %" if share < 0.99 else f"{100 * share:.2f} %"
