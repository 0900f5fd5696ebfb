"""Questions on one frame (PROTOCOL.md): expected.json has some with their answers, which are numbers, compared to a tolerance."""

#: By operation, which is also the part that offers it: the field of the answer, and by how much a number of it may differ.
ANSWERS = {"project": ("pixels", 1e-6), "unproject": ("rays", 1e-7), "weigh": ("weights", 1e-5)}


def only_questions(parts):
    """Whether a program, such as a renderer, reports nothing of a stream."""
    return bool(parts) and set(parts) <= {*ANSWERS, "render"}


def questions_of(case, parts):
    """The questions of a case that a decoder with these parts takes."""
    return [row for row in case.expected.get("questions", []) if row["op"] in parts]


def request_of(case, question):
    """What is asked, without the answer."""
    field, _ = ANSWERS[question["op"]]
    return {"path": str(case.path)} | {name: value for name, value in question.items() if name != field}


def comparable(op, value):
    """The numbers of one row of an answer. A ray may have any length."""
    if op == "unproject" and value is not None:
        x, y, z = value
        return [x / z, y / z]
    return value


def row_differences(op, wanted, found, tolerance):
    if wanted is None or found is None:
        return [] if wanted == found else [f"is {found}, expected {wanted}"]
    if op == "weigh":
        # A camera that is not named has the weight 0.
        cameras = sorted(wanted.keys() | found.keys())
        wanted, found = ([row.get(camera, 0) for camera in cameras] for row in (wanted, found))
    pairs = list(zip(comparable(op, wanted), comparable(op, found), strict=True))
    if all(abs(a - b) <= tolerance * max(1.0, abs(a)) for a, b in pairs):
        return []
    return [f"is {found}, expected {wanted} to {tolerance:g}"]


def answer_differences(question, answer):
    """Lines, one for each row that differs."""
    op = question["op"]
    field, tolerance = ANSWERS[op]
    where = f"{op} at frame {question['frame']}" + (
        f", camera {question['camera']}" if "camera" in question else ""
    )
    if not isinstance(answer, dict):
        return [f"{where}: {answer}"]
    wanted, found = question[field], answer.get(field)
    if not isinstance(found, list) or len(found) != len(wanted):
        return [f"{where}: expected {field} with {len(wanted)} rows"]
    out = []
    for i, (a, b) in enumerate(zip(wanted, found)):
        try:
            lines = row_differences(op, a, b, tolerance)
        except (AttributeError, TypeError, ValueError, ZeroDivisionError):
            lines = [f"is {b}, which has not the form of {a}"]
        out += [f"{where}: {field}/{i} {line}" for line in lines]
    return out


def not_offered(cases, parts):
    """Lines: the questions that a decoder without the part is not asked."""
    asked = [row["op"] for case in cases for row in case.expected.get("questions", [])]
    for op in ANSWERS:
        if op in asked and op not in parts:
            yield f"{op}: not offered, {asked.count(op)} questions are skipped"
