#!/usr/bin/env python3
"""Errors of an oriented simulated block, and whether its stated precision is realistic.

    block_truth.py BLOCK [OUT]     BLOCK: a folder of `orient simulate`; OUT: of `orient block`,
                                   default BLOCK/out

For every photo, from the block adjustment and from its own patches ("alone"): the RMS distance over
the check points, in scan pixels, between their projections by the estimated and by the true pose;
and the pose's normalised error, sqrt(d' C^-1 d / 6).
"""
import json
import math
import pathlib
import re
import sys


def rotation(omega, phi, kappa):
    """Rotation matrix from photo to ground, by rows; angles in degrees."""
    (so, co), (sp, cp), (sk, ck) = (
        (math.sin(math.radians(a)), math.cos(math.radians(a))) for a in (omega, phi, kappa)
    )
    return (
        (cp * ck, -cp * sk, sp),
        (co * sk + so * sp * ck, co * ck - so * sp * sk, -so * cp),
        (so * sk - co * sp * ck, so * ck + co * sp * sk, co * cp),
    )


def project(pose, ground, distance_px):
    """Collinearity equations without principal point."""
    turn = rotation(pose["omega"], pose["phi"], pose["kappa"])
    d = [g - pose[axis] for g, axis in zip(ground, "xyz")]
    x, y, z = (sum(turn[row][col] * d[row] for row in range(3)) for col in range(3))
    return -distance_px * x / z, -distance_px * y / z


def solve(matrix, right):
    """Gaussian elimination for a symmetric positive definite matrix."""
    rows = [list(row) + [value] for row, value in zip(matrix, right)]
    size = len(rows)
    for i in range(size):
        for k in range(i + 1, size):
            factor = rows[k][i] / rows[i][i]
            rows[k] = [a - factor * b for a, b in zip(rows[k], rows[i])]
    solution = [0.0] * size
    for i in reversed(range(size)):
        rest = sum(rows[i][k] * solution[k] for k in range(i + 1, size))
        solution[i] = (rows[i][size] - rest) / rows[i][i]
    return solution


def judge(found, truth, ground, distance_px):
    """Squares of the projection error and of the normalised error; None without a pose."""
    pose = found.get("pose")
    if not pose:
        return None
    squares = []
    for check in truth["check"]:
        a = project(pose, ground[check["point"]], distance_px)
        b = project(truth["pose"], ground[check["point"]], distance_px)
        squares.append((a[0] - b[0]) ** 2 + (a[1] - b[1]) ** 2)
    d = [pose[axis] - truth["pose"][axis] for axis in "xyz"]
    for angle in ("omega", "phi", "kappa"):
        off = (pose[angle] - truth["pose"][angle] + 180) % 360 - 180
        d.append(math.radians(off))
    chi2 = sum(a * b for a, b in zip(d, solve(found["covariance"], d)))
    return sum(squares) / len(squares), chi2 / 6


def principal_distance_mm(block):
    camera = (block / "camera.toml").read_text()
    return float(re.search(r"principal_distance_mm\s*=\s*([\d.]+)", camera).group(1))


def main():
    if len(sys.argv) not in (2, 3):
        sys.exit(__doc__)
    block = pathlib.Path(sys.argv[1])
    out = pathlib.Path(sys.argv[2]) if len(sys.argv) == 3 else block / "out"
    truth = json.loads((block / "truth.json").read_text())
    distance_mm = principal_distance_mm(block)
    sums = {"block": [], "alone": []}
    for photo in truth["photos"]:
        distance_px = distance_mm / (1e-3 * photo["scan"]["pixel_size_um"])
        found = json.loads((out / f"{photo['photo']}.exterior.json").read_text())
        words = []
        for name, result in (("block", found), ("alone", found.get("alone") or {})):
            verdict = judge(result, photo, truth["check_points"], distance_px)
            if not verdict:
                words.append(f"{name} {result.get('status', 'absent')}")
                continue
            sums[name].append(verdict)
            words.append(
                f"{name} {result['status']:6} {math.sqrt(verdict[0]):.3f} px,"
                f" normalised {math.sqrt(verdict[1]):.2f}"
            )
        print(f"{photo['photo']:10} {';  '.join(words)}")
    for name, verdicts in sums.items():
        if verdicts:
            px, chi = (math.sqrt(sum(column) / len(verdicts)) for column in zip(*verdicts))
            print(f"{name}: {len(verdicts)} photos, {px:.3f} px RMS, normalised error {chi:.2f}")


if __name__ == "__main__":
    main()
