"""How well garments are cut out and understood where the table does not fill the picture.

    foldrs synth --out SCENES --count 60
    python benchmarks/rooms.py SCENES [--draws K] [--seed S] [--pictures FOLDER]

Every scene (NAME.jpg, NAME.mask.png, NAME.json as `foldrs synth` writes them) becomes the top of a table:
warped as if seen at an angle onto a part of a picture, with a floor, mostly a wall, and things on the floor
and on the table's edges. Prints the share of masks that overlap the true one by more than 0.95, and of fold
axes found right (dA < 0.1) with the kind given and no scale, from the photograph and from the true mask.
"""

from __future__ import annotations

import argparse
import warnings
from pathlib import Path
from typing import NamedTuple

import cv2
import numpy as np
from rich.console import Console
from rich.progress import track
from rich.table import Table

import foldrs
from foldrs.errors import FoldrsError
from foldrs.evaluation import Kind, load_scenes, measure
from foldrs.evaluation.scenes import Scene
from foldrs.image import Mask, RgbImage, read_image, read_mask
from foldrs.outline import find_outline
from foldrs.segmentation.masks import overlap, touches_border
from foldrs.template import builtin_templates

WIDTH, HEIGHT = 640, 480


class Room(NamedTuple):
    """A scene in a room: the picture, and where the garment is seen in it."""

    picture: RgbImage
    mask: Mask


def room_around(photograph: RgbImage, mask: Mask, rng: np.random.Generator) -> Room:
    """Draw rooms until the whole garment is within the picture."""
    while True:
        room = _draw(photograph, mask, rng)
        if not touches_border(room.mask):
            return room


def _draw(photograph: RgbImage, mask: Mask, rng: np.random.Generator) -> Room:
    room = np.empty((HEIGHT, WIDTH, 3), np.float32)
    room[:] = rng.uniform(20, 230) + rng.normal(0, 25, 3)
    if rng.random() < 0.5:  # a floor of the same make as the table: its corner, tiled
        corner = photograph[:80, :160]
        row = np.concatenate([corner, corner[:, ::-1]], axis=1)
        tile = np.concatenate([row, row[::-1]])
        floor = np.tile(tile, (HEIGHT // 160 + 1, WIDTH // 320 + 1, 1))[:HEIGHT, :WIDTH]
        room[:] = floor * rng.uniform(0.4, 1.1)
    if rng.random() < 0.7:
        room[: int(HEIGHT * rng.uniform(0.03, 0.3))] = rng.uniform(60, 240) + rng.normal(0, 10, 3)
    for _ in range(rng.integers(1, 6)):
        _put_thing(room, rng, rng.random(2) * (WIDTH, HEIGHT), rng.uniform(20, 140))
    height, width = mask.shape
    top = np.array([[0, 0], [width, 0], [width, height], [0, height]], np.float32)
    corners = _table(rng)
    onto = cv2.getPerspectiveTransform(top, corners)
    size = (WIDTH, HEIGHT)
    table = cv2.warpPerspective(photograph, onto, size, flags=cv2.INTER_AREA)
    cover = cv2.warpPerspective(np.ones((height, width), np.float32), onto, size)[..., None]
    cloth = cv2.warpPerspective(mask.astype(np.float32), onto, size) > 0.5
    room = room * (1 - cover) + table * cover
    near = cv2.dilate(cloth.astype(np.uint8), np.ones((25, 25), np.uint8)) > 0
    for _ in range(rng.integers(0, 3)):
        beside, edge = room.copy(), rng.integers(4)
        place = corners[edge] + (corners[(edge + 1) % 4] - corners[edge]) * rng.random()
        _put_thing(beside, rng, place, rng.uniform(20, 90))
        room = np.where(near[..., None], room, beside)
    lit = 1 + 0.15 * rng.normal() * np.linspace(-1, 1, WIDTH)[:, None]
    seen = np.clip(room * lit + rng.normal(0, 2, room.shape), 0, 255).astype(np.uint8)
    return Room(np.asarray(cv2.GaussianBlur(seen, (3, 3), 0), np.uint8), cloth)


def _table(rng: np.random.Generator) -> np.ndarray:
    """Corners of a table top, px; its far side is drawn smaller."""
    half = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * (WIDTH / 2, HEIGHT / 2) * rng.uniform(0.62, 0.95)
    half[:2] *= (rng.uniform(0.75, 1), rng.uniform(0.8, 1))
    turn = rng.normal(0, 0.15)
    turned = half @ np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
    middle = np.array([WIDTH / 2, HEIGHT / 2]) + rng.uniform(-60, 60, 2)
    return np.asarray(turned + middle, np.float32)


def _put_thing(room: np.ndarray, rng: np.random.Generator, place: np.ndarray, size: float) -> None:
    """Draw a box of one colour, about `size` px long."""
    turn, narrow = rng.uniform(0, np.pi), rng.uniform(0.3, 1)
    corners = np.array([[-1, -narrow], [1, -narrow], [1, narrow], [-1, narrow]]) * size / 2
    turned = corners @ np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
    colour = np.clip(rng.uniform(10, 240) + rng.normal(0, 30, 3), 0, 255)
    points = np.int32(turned + place + rng.normal(0, 0.05 * size, (4, 2)))
    cv2.fillConvexPoly(room, points, colour.tolist(), cv2.LINE_AA)


def is_right(scene: Scene, room: Room, mask: Mask | None) -> bool:
    """Whether the fold axis is found, the kind given and the scale unknown."""
    try:
        found = foldrs.fit(room.picture, mask=mask, garment_type=scene.garment_type)
    except FoldrsError:
        return False
    kind = Kind.of(builtin_templates(scene.garment_type), scene.landmarks)
    return bool(measure(scene, found.to_dict(), kind).right)


def main() -> None:
    """Draw the rooms and print one table."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("scenes", type=Path)
    parser.add_argument("--draws", type=int, default=1, help="rooms a scene")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--pictures", type=Path, help="write the rooms there")
    given = parser.parse_args()
    warnings.simplefilter("ignore")
    rng = np.random.default_rng(given.seed)
    masks, photographs, outlined = [], [], []
    scenes = list(load_scenes(given.scenes)) * given.draws
    for number, scene in enumerate(track(scenes)):
        path = given.scenes / f"{scene.name}.jpg"
        room = room_around(read_image(path), read_mask(path.with_suffix(".mask.png")), rng)
        if given.pictures:
            given.pictures.mkdir(parents=True, exist_ok=True)
            cv2.imwrite(str(given.pictures / f"{number:03d}.jpg"), room.picture[..., ::-1])
        try:
            cut_out = find_outline(room.picture).mask
            masks.append(cut_out is not None and overlap(cut_out, room.mask) > 0.95)
        except FoldrsError:
            masks.append(False)
        photographs.append(is_right(scene, room, None))
        outlined.append(is_right(scene, room, room.mask))
    shown = Table("rooms", "masks (%)", "axes (%)", "axes, true masks (%)")
    shown.add_row(str(len(scenes)), *(f"{100 * np.mean(r):.1f}" for r in (masks, photographs, outlined)))
    Console().print(shown)


if __name__ == "__main__":
    main()
