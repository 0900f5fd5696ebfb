"""Which rules of spec/issues.md have cases."""

from reference.container import DATA

from . import case

# Rules that a reader can check but that no file of less than 64 kB shows, with the reason.
NOT_SHOWN = {}


def report(cases):
    """By rule the faulty cases; missing: rules without one that are not in NOT_SHOWN."""
    found = {}
    for one in cases:
        if one.tier == "faulty":
            rule = case.issue(case.made(one)[1][0])
            found.setdefault(rule, []).append(one.name)
    rules = [case.issue(rule["number"]) for rule in DATA["issues"]]
    missing = [rule for rule in rules if rule not in found and rule not in NOT_SHOWN]
    tiers = {tier: sum(c.tier == tier for c in cases) for tier in ("valid", "uncommon", "faulty")}
    shown = len([rule for rule in rules if rule in found])
    return {
        "cases": tiers,
        "rules": len(rules),
        "rules_with_cases": shown,
        "percent": round(100 * shown / (len(rules) - len(NOT_SHOWN)), 1),
        "not_shown": NOT_SHOWN,
        "missing": missing,
        "once": sorted(rule for rule, names in found.items() if len(names) == 1),
        "by_rule": {rule: found.get(rule, []) for rule in rules},
    }
