"""Excess of answers over the best known, and confidence intervals of shares."""
import math
import statistics

import numpy as np

import programs

# Excess from which an answer counts as another exit, and as an inexact one.
SLIGHT, CLOSE = 0.05, 0.01


def depths(answers):
    return np.array([a["depth"] for a in answers])


def asked(model, queries, effort="refined"):
    return depths(programs.answers(model, queries, effort))


def within(depth, best):
    """Returns the shares of answers within 5 % and within 1 % of the best known."""
    return {"within_5": float((depth <= (1 + SLIGHT) * best).mean()), "within_1": float((depth <= (1 + CLOSE) * best).mean())}


def wilson(share, count):
    """Returns the 95 % interval of a share of `count` samples (Wilson, "Probable inference, the law of succession, and statistical inference", 1927,
    doi:10.1080/01621459.1927.10502953)."""
    z = statistics.NormalDist().inv_cdf(0.975)
    middle, half = share + z * z / (2 * count), z * math.sqrt(share * (1 - share) / count + z * z / (4 * count * count))
    return max(0.0, (middle - half) / (1 + z * z / count)), min(1.0, (middle + half) / (1 + z * z / count))


def interval_of_mean(shares, intervals):
    """Returns the interval of the mean of independent shares from their Wilson intervals: the squares of the half widths add up.

    Source: Newcombe, "Interval estimation for the difference between independent proportions: comparison of eleven methods", 1998,
    doi:10.1002/(SICI)1097-0258(19980430)17:8<873::AID-SIM779>3.0.CO;2-I, method 10, here for a mean instead of a difference.
    """
    low = math.hypot(*(p - low for p, (low, _) in zip(shares, intervals))) / len(shares)
    high = math.hypot(*(high - p for p, (_, high) in zip(shares, intervals))) / len(shares)
    middle = sum(shares) / len(shares)
    return middle - low, middle + high
