"""Compares what a decoder reports with what a case expects."""

#: What a decoder may leave out, and the names of arrays that belong to each.
PARTS = (
    "check",
    "live",
    "join",
    "mesh",
    "camera",
    "visibility",
    "colours",
    "texturing",
    "video",
    "sound",
    "environment",
    "data",
)


def part_of(name):
    """The part that an array of a frame belongs to."""
    words = name.split("/")
    first = words[0]
    if first == "mesh":
        return "colours" if words[-1] == "colours" else "mesh"
    return {"tiles": "video"}.get(first, first)


def number(value):
    """64-bit integers may be strings of digits."""
    return int(value)


def claimed(arrays, parts):
    return {name: value for name, value in arrays.items() if part_of(name) in parts}


def array_differences(where, expected, found):
    """Of two objects of hashes by name."""
    for name in sorted(expected.keys() | found.keys()):
        if name not in found:
            yield f"{where}: {name} is missing"
        elif name not in expected:
            # A decoder may compute normals where none are sent.
            if not name.endswith("/normals"):
                yield f"{where}: {name} is not expected"
        elif expected[name] != found[name]:
            yield f"{where}: {name} is {found[name][:12]}..., expected {expected[name][:12]}..."


def frame_differences(expected, found, parts, all_of_them, others=False):
    """all_of_them: no frame may be missing. Every frame that is there has to be right. others: further ones may be there."""
    wanted = {number(frame["time"]): claimed(frame["arrays"], parts) for frame in expected}
    times = [number(frame["time"]) for frame in found]
    for time in sorted(set(times)):
        if times.count(time) > 1:
            yield f"frame {time}: reported {times.count(time)} times"
    # After damage a decoder may find a group later than its place.
    if all_of_them and times != sorted(times):
        yield "frames are not in order of time"
    for frame in found:
        time = number(frame["time"])
        if time not in wanted:
            if others:
                continue
            yield f"frame {time}: called intact, but there is none"
        else:
            yield from array_differences(f"frame {time}", wanted[time], claimed(frame["arrays"], parts))
    if all_of_them:
        for time in sorted(wanted.keys() - set(times)):
            yield f"frame {time}: missing"


def chunk_keys(sound):
    return {(number(chunk["start"]), chunk["packets"], chunk["sha256"]) for chunk in sound["chunks"]}


def same_sound(expected, found):
    return all(str(expected[key]) == str(found.get(key)) for key in ("packets", "start", "sha256"))


def sound_differences(expected, found, all_of_it):
    """Where some packets may be missing, those that are there are compared if both sides list chunks."""
    for track in sorted(found.keys() - expected.keys()):
        yield f"sound of track {track}: there is none"
    for track, wanted in sorted(expected.items()):
        sound = found.get(track)
        if sound is None:
            if all_of_it:
                yield f"sound of track {track}: missing"
        elif same_sound(wanted, sound):
            continue
        elif all_of_it or sound["packets"] == wanted["packets"]:
            yield (
                f"sound of track {track}: {sound['packets']} packets from {sound['start']} with "
                f"{sound['sha256'][:12]}..., expected {wanted['packets']} from {wanted['start']} with "
                f"{wanted['sha256'][:12]}..."
            )
        elif sound["packets"] > wanted["packets"]:
            yield f"sound of track {track}: {sound['packets']} packets, expected at most {wanted['packets']}"
        elif "chunks" in sound and "chunks" in wanted and not chunk_keys(sound) <= chunk_keys(wanted):
            yield f"sound of track {track}: a packet differs"


def environment_differences(expected, found, all_of_it):
    for track in sorted(expected.keys() | found.keys()):
        wanted, there = expected.get(track, {}), found.get(track)
        if there is None and not all_of_it:
            continue
        yield from array_differences(f"environment of track {track}", wanted, there or {})


def summary_differences(expected, found):
    """Only what both state."""
    for key in sorted(expected.keys() & found.keys()):
        wanted, there = expected[key], found[key]
        if key == "tracks":
            common = {name for row in (*wanted, *there) for name in row}
            common = {name for name in common if all(name in row for row in (*wanted, *there))} | {"id"}
            wanted, there = (
                sorted([{name: row.get(name) for name in sorted(common)} for row in rows], key=str)
                for rows in (wanted, there)
            )
        elif key == "cameras":
            wanted, there = sorted(wanted), sorted(there)
        if wanted != there:
            yield f"summary: {key} is {there}, expected {wanted}"


def issue_differences(expected, found):
    """The first issue, where the first fault is; what else is found there or after it is free."""
    if not expected:
        return
    first = expected[0]
    rows = [(number(row["offset"]), row["issue"]) for row in found]
    if not rows:
        yield f"no issue, expected {first['issue']} at {first['offset']}"
        return
    lowest = min(offset for offset, _ in rows)
    names = [name for offset, name in rows if offset == lowest]
    if lowest != number(first["offset"]) or first["issue"] not in names:
        yield f"first issue is {' '.join(names)} at {lowest}, expected {first['issue']} at {first['offset']}"


def content_differences(expected, report, parts, all_of_it):
    """What is called intact: frames, sound and environment."""
    if "frames" in expected:
        # A fault that decoding does not meet takes nothing from the frames of who does not look for it.
        others = bool(expected.get("needs_check"))
        yield from frame_differences(expected["frames"], report["frames"], parts, all_of_it, others)
        there = {number(frame["time"]) for frame in report["frames"]}
        for time in expected.get("required", []):
            if time not in there:
                yield f"frame {time}: missing, although the fault does not touch it"
    if "sound" in parts and "sounds" in expected:
        yield from sound_differences(expected["sounds"], report.get("sounds", {}), all_of_it)
    if "environment" in parts and "environment" in expected:
        yield from environment_differences(expected["environment"], report.get("environment", {}), all_of_it)


LIMIT = "FVV-7001"


def has_other_limits(tier, report):
    """Whether a stream that the limits of the reference library decide is judged by others: one who takes less refuses it by its
    rule, and one who takes more finds nothing wrong."""
    if tier == "faulty":
        return report["status"] == "whole"
    return report["status"] != "whole" and LIMIT in [row["issue"] for row in report.get("issues", [])[:1]]


def differences(tier, expected, report, parts):
    """Lines, one for each difference; none: they agree. A report that lacks a field raises KeyError."""
    found = []
    status = report["status"]
    if expected.get("limits") and has_other_limits(tier, report):
        return found
    if status not in ("whole", "damaged", "refused"):
        found.append(f"status is {status}, expected whole, damaged or refused")
    if tier == "faulty":
        has_check = "check" in parts
        if status == "whole" and (has_check or not expected.get("needs_check")):
            found.append(f"status is whole, expected {expected['status']}")
        if has_check:
            found += issue_differences(expected["issues"], report.get("issues", []))
    else:
        if status != "whole":
            issues = " ".join(row["issue"] for row in report.get("issues", []))
            found.append(f"status is {status} {issues}".rstrip() + ", expected whole")
        elif report.get("issues"):
            found.append(f"{len(report['issues'])} issues, expected none")
        found += summary_differences(expected.get("summary", {}), report.get("summary", {}))
    found += content_differences(expected, report, parts, tier != "faulty")
    return found


def describe_differences(tier, expected, report, parts):
    """The same for any answer: a text in place of a report, or a report of the wrong form, is a difference."""
    if isinstance(report, str):
        return [report]
    try:
        return differences(tier, expected, report, parts)
    except KeyError as error:
        return [f"the report, or a row of it, lacks the field {error} (PROTOCOL.md, The report)"]
    except (TypeError, ValueError, AttributeError) as error:
        return [f"the report has not the form of the protocol: {type(error).__name__}: {error}"]
