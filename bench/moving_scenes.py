"""Scenes in which many blocks move at once, as scene files: what bench/moving.py runs."""
import math
import random

G = 9.81


def box(name, low, high, kind="rigid", **more):
    material = {"material": "stone"} if kind == "rigid" else {}
    return {"name": name, "kind": kind, **material, "shape": {"type": "box", "min": low, "max": high}, **more}


def scene(title, blocks, friction, end_time):
    return {"title": title, "materials": {"stone": {"density": 2000}},
            "joint": {"friction_angle_deg": friction}, "time_step": 5e-3, "end_time": end_time, "blocks": blocks}


def pile(across, layers, end_time):
    """Boxes of 0.4 to 0.7 m with random spin that fall into a bin of fixed sides."""
    numbers, half = random.Random(1), across / 2
    far, top = half + 1, max(4, layers)
    blocks = [box("floor", [-far, -far, -0.5], [far, far, 0], "fixed"),
              box("west", [-far, -far, 0], [-half, far, top], "fixed"),
              box("east", [half, -far, 0], [far, far, top], "fixed"),
              box("south", [-half, -far, 0], [half, -half, top], "fixed"),
              box("north", [-half, half, 0], [half, far, top], "fixed")]
    for i in range(layers * across * across):
        layer, row, column = i // across ** 2, i // across % across, i % across
        middle = [column - half + 0.5, row - half + 0.5, 0.7 + layer]
        sides = [numbers.uniform(0.2, 0.35) for _ in range(3)]
        blocks.append(box(f"box{i}", [m - s for m, s in zip(middle, sides)], [m + s for m, s in zip(middle, sides)],
                          angular_velocity=[numbers.uniform(-3, 3) for _ in range(3)]))
    return scene(f"Pile of {layers * across ** 2} boxes in a bin", blocks, 30, end_time)


def hull_pile(across, layers, end_time):
    """As `pile`, hulls of 12 random points on ellipsoids instead of boxes."""
    numbers, document = random.Random(3), pile(across, layers, end_time)
    for block in document["blocks"]:
        if block["kind"] == "rigid":
            low, high = block["shape"]["min"], block["shape"]["max"]
            points = []
            for _ in range(12):
                way = [numbers.gauss(0, 1) for _ in range(3)]
                points.append([(a + b) / 2 + (b - a) / 2 * w / math.hypot(*way) for a, b, w in zip(low, high, way)])
            block["shape"] = {"type": "hull", "points": points}
    return {**document, "title": f"Pile of {layers * across ** 2} random hulls in a bin"}


def shaken_wall(columns, rows, direction, end_time, amplitude=0.5):
    """A wall in running bond; its base is shaken at 2 Hz along x (in its plane) or y (across). `amplitude`: g."""
    shaking = f"{amplitude * G:.6g}*cos(4*pi*t)"
    formula = [shaking if direction == axis else "0" for axis in "xyz"]
    blocks = [box("base", [-2, -2, -1], [0.4 * columns + 2, 2, 0], "prescribed",
                  motion={"acceleration": {"formula": formula}})]
    for row in range(rows):
        shift = 0.2 * (row % 2)
        for i in range(columns + row % 2):
            low, high = max(0, 0.4 * i - shift), min(0.4 * columns, 0.4 * (i + 1) - shift)
            blocks.append(box(f"brick{row}_{i}", [round(low, 9), 0, round(0.2 * row, 9)],
                              [round(high, 9), 0.2, round(0.2 * (row + 1), 9)]))
    return scene(f"Wall of {len(blocks) - 1} bricks, shaken along {direction}", blocks, 35, end_time)


def struck_wall(columns, rows, end_time):
    """The wall in running bond on a fixed base; a cube of 1 t, 1 cm off, flies into its middle with 3 m/s."""
    document = shaken_wall(columns, rows, "y", end_time, amplitude=0)
    base, *bricks = document["blocks"]
    side, middle, low = 0.5 ** (1 / 3), 0.2 * columns, 0.1 * rows
    cube = box("cube", [middle - side / 2, -0.01 - side, low], [middle + side / 2, -0.01, low + side],
               velocity=[0, 3, 0])
    base = {key: value for key, value in base.items() if key != "motion"} | {"kind": "fixed"}
    return {**document, "title": f"Wall of {len(bricks)} bricks hit by 1 t", "blocks": [base, *bricks, cube]}


def dominoes(count, end_time, thickness=0.3, friction=10):
    """The first one leans by a little more than it can; thick ones come to rest against each other."""
    blocks = [box("ground", [-5, -5, -1], [count, 5, 0], "fixed")]
    for i in range(count):
        blocks.append(box(f"domino{i}", [round(0.6 * i, 9), 0, 0], [round(0.6 * i + thickness, 9), 1, 1.5]))
    lean = round(math.degrees(math.atan(thickness / 1.5)) + 0.1, 1)
    blocks[1]["pose"] = {"rotation": {"axis": [0, 1, 0], "angle_deg": lean}, "about": [thickness, 0, 0]}
    return scene(f"{count} dominoes", blocks, friction, end_time)


def pulled_base(count, end_time):
    blocks = [box("ground", [-5, -5, -1], [9, 5, 0], "fixed"),
              box("base", [0, 0, 0], [1, 1, 0.5], "prescribed", motion={"acceleration": {"formula": ["8", "0", "0"]}})]
    blocks += [box(f"drum{i}", [0, 0, 0.5 * (i + 1)], [1, 1, 0.5 * (i + 2)]) for i in range(count)]
    return scene(f"Tower of {count} whose base is pulled away", blocks, 30, end_time)


def falling_arch(count, end_time):
    """A round arch; its right support moves out and down."""
    blocks = []
    for i in range(-1, count + 1):
        corner = [[r * math.cos(j * math.pi / count), 0, r * math.sin(j * math.pi / count)]
                  for r, j in ((5, i), (5, i + 1), (5.8, i + 1), (5.8, i))]
        shape = {"type": "prism", "polygon": corner, "sweep": [0, 1, 0]}
        blocks.append({"name": f"voussoir{i}", "kind": "rigid", "material": "stone", "shape": shape})
    blocks[0] = {"name": "left", "kind": "fixed", "shape": blocks[0]["shape"]}
    blocks[-1] = {"name": "right", "kind": "prescribed", "shape": blocks[-1]["shape"],
                  "motion": {"acceleration": {"formula": ["-6", "0", "-2"]}}}
    return scene(f"Arch of {count} that loses a support", blocks, 35, end_time)


def vault(courses, length, piers, end_time):
    """A dry barrel vault, `length` stones of 0.8 m in bond, on two rows of piers; the last one on the left is gone."""
    inner, outer, bay, blocks = 2, 2.4, 0.8 * length / piers, []
    for i in range(piers):
        for side, x in (("left", -outer), ("right", inner)):
            if (side, i) != ("left", piers - 1):
                blocks.append(box(f"{side}{i}", [x, bay * i, -1.5], [x + outer - inner, bay * (i + 1), 0], "fixed"))
    held = len(blocks)
    for course in range(courses):
        shift = 0.4 * (course % 2)
        for i in range(length + course % 2):
            low, high = max(0, 0.8 * i - shift), min(0.8 * length, 0.8 * (i + 1) - shift)
            corner = [[-r * math.cos(j * math.pi / courses), low, r * math.sin(j * math.pi / courses)]
                      for r, j in ((inner, course), (outer, course), (outer, course + 1), (inner, course + 1))]
            blocks.append({"name": f"stone{course}_{i}", "kind": "rigid", "material": "stone",
                           "shape": {"type": "prism", "polygon": corner, "sweep": [0, high - low, 0]}})
    return scene(f"Vault of {len(blocks) - held} stones that loses a pier", blocks, 35, end_time)


def on_plane(degrees, x, y, z):
    """A box in axes down a plane that dips so, along its strike, and off it."""
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    return {"type": "hull", "points": [[c * a + s * k, b, -s * a + c * k] for a in x for b in y for k in z]}


def slope(across, end_time):
    """Two layers of blocks in bond on a plane of 35 degrees, friction 25 degrees."""
    blocks = [{"name": "bed", "kind": "fixed", "shape": on_plane(35, (-5, 30), (-5, across + 5), (-1, 0))}]
    for i in range(2 * across ** 2):
        layer, row, column = i // across ** 2, i // across % across, i % across
        x, z = column + 0.5 * layer, 0.6 * layer
        blocks.append({"name": f"block{i}", "kind": "rigid", "material": "stone",
                       "shape": on_plane(35, (x, x + 1), (row, row + 1), (z, z + 0.6))})
    return scene(f"Slope of {2 * across ** 2} blocks that slides", blocks, 25, end_time)


def jointed_slope(rows, columns, sheets, end_time):
    """Sheets of blocks in bond, friction 35 degrees, on a plane of 45, friction 25 degrees, that no toe holds. Were
    both the same, all joints would slide or not with equal right."""
    blocks = [{"name": "bed", "kind": "fixed", "joint_group": "bed",
               "shape": on_plane(45, (-5, 2 * rows), (-5, columns + 5), (-1, 0))}]
    for sheet in range(sheets):
        shift = 0.5 * (sheet % 2)
        for column in range(columns):
            for row in range(rows + sheet % 2):
                x = (max(0, row - shift), min(rows, row + 1 - shift))
                blocks.append({"name": f"block{sheet}_{column}_{row}", "kind": "rigid", "material": "stone",
                               "joint_group": "rock",
                               "shape": on_plane(45, x, (column, column + 1), (0.5 * sheet, 0.5 * (sheet + 1)))})
    return {**scene(f"Jointed slope of {len(blocks) - 1} blocks that slides", blocks, 35, end_time),
            "joints": [{"between": ["bed", "rock"], "friction_angle_deg": 25}]}


def swarms(across, end_time):
    """Two cubes of boxes with random spin that fly at each other; no weight, no support: momentum stays."""
    numbers, count = random.Random(2), across ** 3
    blocks = []
    for i in range(2 * count):
        side, layer, row, column = i // count, i // across ** 2 % across, i // across % across, i % across
        middle = [column + side * (across + 1), row + 0.2 * side, layer + 0.3 * side]
        sides = [numbers.uniform(0.2, 0.35) for _ in range(3)]
        blocks.append(box(f"box{i}", [m - s for m, s in zip(middle, sides)], [m + s for m, s in zip(middle, sides)],
                          velocity=[2 - 4 * side, 0, 0],
                          angular_velocity=[numbers.uniform(-1, 1) for _ in range(3)]))
    return {**scene(f"Two swarms of {count} boxes that meet", blocks, 30, end_time), "gravity": [0, 0, 0]}


def boulder(seed, size, ratio, count=5):
    """A cube of 2 m slides on small cubes; `size`: of these, m; `ratio`: of the mass to theirs."""
    numbers = random.Random(seed)
    blocks = [box("ground", [-50, -50, -1], [50, 50, 0], "fixed")]
    for i in range(count):
        angle, far = 2 * math.pi * i / count + numbers.uniform(-0.2, 0.2), numbers.uniform(0.5, 0.8)
        x, y = far * math.cos(angle), far * math.sin(angle)
        blocks.append(box(f"pebble{i}", [x, y, 0], [x + size, y + size, size],
                          velocity=[numbers.uniform(-0.8, 0.8), numbers.uniform(-0.5, 0.5), 0]))
    blocks.append(box("boulder", [-1, -1, size], [1, 1, 2 + size], velocity=[1, 0, 0], angular_velocity=[0, 0, 0.13]))
    blocks[-1]["material"] = "dense"
    document = scene(f"Boulder on {count} pebbles, mass ratio {ratio:.0e}", blocks, 30, 0.3)
    document["materials"]["dense"] = {"density": 2000 * ratio * size ** 3 / 8}
    return document


def deformable(document, young):
    """The same of deformable blocks; `young`: Pa."""
    stone = {**document["materials"]["stone"], "young": young, "poisson": 0.2}
    blocks = [{**block, "kind": "deformable"} if block["kind"] == "rigid" else block for block in document["blocks"]]
    return {**document, "materials": {"stone": stone}, "blocks": blocks}
