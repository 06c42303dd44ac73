"""Stage 0 finds the garment's outline on tables of many kinds, and names what keeps it from doing so."""

from __future__ import annotations

import json
import threading
import warnings
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image
from shapely.geometry import Polygon

from foldrs import fit
from foldrs.camera import TablePlane
from foldrs.errors import (
    GarmentCutOffError,
    GarmentCutOffWarning,
    GarmentTooSmallError,
    ImageNotFoundError,
    ImageTooLargeError,
    InvalidOutlineError,
    NoGarmentError,
    NotAnImageError,
    OutlineError,
    SeveralGarmentsError,
)
from foldrs.outline import as_outline, as_photograph, find_outline, outline_of_mask, segment
from foldrs.parameters import OutlineParameters, Parameters
from foldrs.scale import Marker, Sheet

WIDTH, HEIGHT = 640, 480
PULLOVER = np.array(  # a folded pullover with a gap of 12 px between one sleeve and the body
    [
        [240, 110], [290, 120], [340, 110], [440, 150], [490, 330], [455, 340], [412, 200],
        [415, 370], [225, 370], [222, 190], [182, 250], [150, 225], [190, 145],
    ],
    float,
)  # fmt: skip


def filled(points: np.ndarray, shape: tuple[int, int] = (HEIGHT, WIDTH)) -> np.ndarray:
    """Mask (h, w) bool of a polygon."""
    mask = np.zeros(shape, np.uint8)
    cv2.fillPoly(mask, [np.round(points).astype(np.int32)], 1)
    return mask > 0


def iou(a: np.ndarray, b: np.ndarray) -> float:
    first, second = Polygon(a).buffer(0), Polygon(b).buffer(0)
    return first.intersection(second).area / first.union(second).area


def noise(rng: np.random.Generator, size: float) -> np.ndarray:
    """Smooth noise (h, w) of unit spread whose patches are about `size` px."""
    grain = rng.standard_normal((int(HEIGHT / size) + 2, int(WIDTH / size) + 2)).astype(np.float32)
    whole = cv2.resize(grain, (WIDTH, HEIGHT), interpolation=cv2.INTER_CUBIC)
    return whole / whole.std()


def photograph(
    cloth: tuple[int, int, int] = (60, 90, 150),
    table: tuple[int, int, int] = (225, 220, 210),
    *,
    print_colour: tuple[int, int, int] | None = None,
    pattern: str = "none",
    grain: float = 0.0,
    shadow: float = 0.3,
    vignette: float = 0.3,
    shape: np.ndarray = PULLOVER,
) -> np.ndarray:
    """A synthetic photograph (h, w, 3) uint8 of cloth on a vignetted table, with a soft shadow and noise."""
    rng = np.random.default_rng(7)
    y, x = np.mgrid[:HEIGHT, :WIDTH].astype(np.float32)
    mask = cv2.GaussianBlur(filled(shape).astype(np.float32), (0, 0), 0.6)
    marks = {
        "none": np.zeros_like(x),
        "stripes": ((x + y) / 22 % 1 < 0.5).astype(np.float32),
        "dots": ((x / 18 % 1 - 0.5) ** 2 + (y / 18 % 1 - 0.5) ** 2 < 0.07).astype(np.float32),
        "motif": ((x - 320) ** 2 + (y - 250) ** 2 < 60**2).astype(np.float32),
    }[pattern][..., None]
    garment = np.array(cloth) * (1 - marks) + np.array(print_colour or cloth) * marks
    garment *= (1 + 0.03 * noise(rng, 30) + 0.02 * noise(rng, 2))[..., None]
    wood = noise(rng, 4) * 0.5 + np.sin(y / 9 + 2 * noise(rng, 150)) * 0.7
    ground = np.array(table) + (grain * wood)[..., None]
    blurred = cv2.GaussianBlur(np.roll(mask, (4, 3), axis=(0, 1)), (0, 0), 6)
    ground *= (1 - shadow * blurred)[..., None]
    picture = ground * (1 - mask[..., None]) + garment * mask[..., None]
    picture *= (1 - vignette * 2 * ((x / WIDTH - 0.45) ** 2 + (y / HEIGHT - 0.5) ** 2))[..., None]
    picture += rng.normal(0, 2, picture.shape)
    picture = np.clip(picture, 0, 255).astype(np.uint8)
    _, jpeg = cv2.imencode(".jpg", picture, [cv2.IMWRITE_JPEG_QUALITY, 85])
    return cv2.imdecode(jpeg, cv2.IMREAD_COLOR)


PHOTOGRAPHS = {
    "blue on a bright table": ({}, 0.97),
    "strong shadow": ({"shadow": 0.5}, 0.97),
    "white on light grey": ({"cloth": (240, 240, 238), "table": (200, 198, 190)}, 0.94),
    "grey on white": ({"cloth": (180, 182, 185), "table": (235, 235, 230)}, 0.92),
    "dark on dark": ({"cloth": (25, 25, 45), "table": (60, 52, 45)}, 0.96),
    "beige on wood": ({"cloth": (215, 200, 180), "table": (160, 120, 80), "grain": 12}, 0.96),
    "red on wood": ({"cloth": (150, 40, 50), "table": (160, 120, 80), "grain": 15}, 0.97),
    "striped, one stripe nearly the table's colour": (
        {"pattern": "stripes", "cloth": (40, 50, 110), "print_colour": (222, 218, 212)},
        0.90,
    ),
    "dots of the table's colour": (
        {"pattern": "dots", "cloth": (30, 110, 90), "print_colour": (225, 220, 210)},
        0.92,
    ),
    "dark motif on pale cloth": (
        {
            "pattern": "motif",
            "cloth": (245, 245, 245),
            "print_colour": (40, 20, 60),
            "table": (205, 203, 196),
        },
        0.94,
    ),
}


@pytest.mark.parametrize("name", PHOTOGRAPHS)
def test_outline_on_many_tables(name: str) -> None:
    options, floor = PHOTOGRAPHS[name]
    found = find_outline(photograph(**options))
    assert iou(found.points, PULLOVER) >= floor
    assert Polygon(found.points).is_valid


def test_gap_between_sleeve_and_body_stays_open() -> None:
    mask = segment(photograph())
    assert not mask[255, 200:215].any()
    assert mask[215, 175:190].all()


def test_finds_the_same_at_any_size() -> None:
    small = photograph()
    want = find_outline(small).points
    for width, height in [(320, 240), (2400, 1800)]:
        found = find_outline(cv2.resize(small, (width, height), interpolation=cv2.INTER_AREA))
        scale = width / WIDTH
        assert iou((found.points + 0.5) / scale - 0.5, want) > 0.975


def test_same_photograph_same_outline_whatever_else_runs() -> None:
    picture = photograph(pattern="dots", print_colour=(225, 220, 210))
    want = find_outline(picture).points
    results: list[np.ndarray] = []

    def work(seed: int) -> None:
        cv2.setRNGSeed(seed)
        results.append(find_outline(picture).points)

    threads = [threading.Thread(target=work, args=(seed,)) for seed in range(3)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(results) == 3
    assert all(np.array_equal(result, want) for result in results)


def test_scenes(scenes: Path) -> None:
    scores = []
    for truth in sorted(scenes.glob("*.json")):
        found = find_outline(truth.with_suffix(".jpg"))
        scores.append(iou(found.points, np.array(json.loads(truth.read_text())["outline_image"])))
    assert len(scores) >= 50
    assert np.mean(scores) >= 0.975
    assert min(scores) >= 0.93


def test_empty_tables_hold_no_garment() -> None:
    for grain in (0, 15):
        with pytest.raises(NoGarmentError, match="table"):
            find_outline(photograph(table=(190, 150, 110), grain=grain, shape=np.zeros((3, 2))))
    with pytest.raises(NoGarmentError, match="one colour"):
        find_outline(np.full((100, 120, 3), 90, np.uint8))


def test_cloth_that_fills_the_picture_is_no_garment() -> None:
    mask = np.ones((100, 100), bool)
    with pytest.raises(NoGarmentError, match="whole picture"):
        find_outline(mask)
    corners = np.array([[-9, -9], [700, -9], [700, 500], [-9, 500]])
    with pytest.raises((NoGarmentError, GarmentCutOffError)):
        find_outline(photograph(shape=corners))


def test_several_garments_are_not_chosen_between() -> None:
    picture = photograph(shape=np.array([[80, 100], [260, 100], [260, 300], [80, 300]]))
    other = photograph(shape=np.array([[380, 120], [560, 120], [560, 330], [380, 330]]))
    with pytest.raises(SeveralGarmentsError, match="several"):
        find_outline(np.concatenate([picture[:, :320], other[:, 320:]], axis=1))


def test_two_garments_are_not_chosen_between_for_one_being_in_the_middle() -> None:
    picture = photograph(shape=np.array([[220, 140], [420, 140], [420, 340], [220, 340]]))
    cv2.rectangle(picture, (20, 20), (170, 170), (150, 40, 40), cv2.FILLED)
    with pytest.raises(SeveralGarmentsError, match="several"):
        find_outline(picture)


@pytest.mark.parametrize("width", [3, 7, 11])
def test_joints_of_the_table_are_no_part_of_the_garment(width: int) -> None:
    picture = photograph()
    for start, end in (((0, 300), (639, 280)), ((330, 0), (320, 479))):
        joint = np.zeros((HEIGHT, WIDTH), np.uint8)
        cv2.line(joint, start, end, 1, width)
        picture[(joint > 0) & ~filled(PULLOVER)] = (70, 60, 50)
    assert iou(find_outline(picture).points, PULLOVER) > 0.95


def test_a_small_thing_beside_the_garment_is_ignored() -> None:
    picture = photograph()
    cv2.circle(picture, (580, 420), 18, (20, 20, 20), cv2.FILLED)
    assert iou(find_outline(picture).points, PULLOVER) > 0.97


def test_garment_cut_off_by_the_border() -> None:
    with pytest.raises(GarmentCutOffError, match="border"):
        find_outline(photograph(shape=PULLOVER + np.array([0, 180])))
    touching = PULLOVER - [0, 116]
    with pytest.warns(GarmentCutOffWarning, match="border"):
        find_outline(filled(touching))
    with pytest.raises(GarmentCutOffError, match="border"):
        find_outline(filled(PULLOVER + np.array([0, 180])))


def in_a_room(
    picture: np.ndarray,
    shape: np.ndarray,
    corners: list[list[float]],
    *,
    floor: tuple[int, int, int] = (70, 60, 55),
) -> tuple[np.ndarray, np.ndarray]:
    """A photograph as a table top in a room with a wall, a cable and a box; the garment's outline there."""
    rng = np.random.default_rng(3)
    room = np.empty((HEIGHT, WIDTH, 3), np.float32)
    room[:] = floor
    room[:70] = (205, 200, 190)
    room += (6 * noise(rng, 3))[..., None]
    frame = np.array([[0, 0], [WIDTH, 0], [WIDTH, HEIGHT], [0, HEIGHT]], np.float32)
    onto = cv2.getPerspectiveTransform(frame, np.array(corners, np.float32))
    top = cv2.warpPerspective(picture, onto, (WIDTH, HEIGHT), flags=cv2.INTER_AREA)
    cover = cv2.warpPerspective(np.ones((HEIGHT, WIDTH), np.float32), onto, (WIDTH, HEIGHT))
    room = np.where(cover[..., None] > 0.5, top, room)
    cv2.rectangle(room, (560, 40), (639, 150), (60, 120, 60), cv2.FILLED)
    cv2.polylines(room, [np.array([[0, 120], [60, 90], [130, 95]])], False, (20, 20, 20), 3, cv2.LINE_AA)
    room += rng.normal(0, 2, room.shape)
    outline = cv2.perspectiveTransform(shape.reshape(1, -1, 2), onto)[0]
    return np.clip(cv2.GaussianBlur(room, (0, 0), 0.6), 0, 255).astype(np.uint8), outline


TABLES = {  # corners of the table top, px
    "cut by three sides of the picture": [[-40, 60], [700, 40], [690, 520], [-60, 530]],
    "cut by one side": [[70, 80], [560, 60], [620, 520], [30, 530]],
    "seen whole": [[80, 70], [560, 50], [600, 440], [50, 450]],
}
CLOTHS = {
    "plain": {},
    "red on wood": PHOTOGRAPHS["red on wood"][0],
    "a dark motif": {"pattern": "motif", "cloth": (90, 110, 190), "print_colour": (240, 230, 40)},
}


@pytest.mark.parametrize("cloth", CLOTHS)
@pytest.mark.parametrize("table", TABLES)
def test_a_table_need_not_fill_the_picture(table: str, cloth: str) -> None:
    picture, outline = in_a_room(photograph(**CLOTHS[cloth]), PULLOVER, TABLES[table])
    assert iou(find_outline(picture).points, outline) > 0.95


def test_two_garments_on_a_table_in_a_room_are_not_chosen_between() -> None:
    squares = [np.array([[x, 120], [x + 170, 120], [x + 170, 320], [x, 320]]) for x in (90, 380)]
    one, other = (photograph(shape=square) for square in squares)
    both = np.concatenate([one[:, :320], other[:, 320:]], axis=1)
    for corners in TABLES.values():
        picture, _ = in_a_room(both, PULLOVER, corners)
        with pytest.raises(SeveralGarmentsError, match="several"):
            find_outline(picture)


def test_a_print_on_cloth_cut_by_the_border_is_no_garment() -> None:
    low = PULLOVER + np.array([0, 180])
    picture = photograph(shape=low)
    cv2.circle(picture, (320, 400), 45, (240, 220, 60), cv2.FILLED)
    with pytest.raises(GarmentCutOffError, match="border"):
        find_outline(picture)


def test_a_large_print_on_a_large_towel_is_no_garment() -> None:
    towel = np.array([[110, 60], [540, 60], [540, 420], [110, 420]], float)
    picture = photograph(shape=towel)
    cv2.circle(picture, (320, 240), 36, (240, 220, 60), cv2.FILLED)
    assert iou(find_outline(picture).points, towel) > 0.97


def test_a_board_among_things_is_no_garment() -> None:
    picture = photograph(cloth=(120, 170, 200))
    rng = np.random.default_rng(5)
    board = np.zeros((HEIGHT, WIDTH), bool)
    board[40:450, 90:560] = True
    around = np.where(np.arange(HEIGHT)[:, None] // 6 % 2 == 0, 210.0, 90.0) + rng.normal(
        0, 8, (HEIGHT, WIDTH)
    )
    picture = np.where(board[..., None], picture, np.clip(around, 0, 255).astype(np.uint8)[..., None])
    cv2.line(picture, (600, 0), (580, 300), (30, 20, 20), 9, cv2.LINE_AA)
    cv2.circle(picture, (30, 440), 40, (20, 20, 25), cv2.FILLED)
    assert iou(find_outline(picture).points, PULLOVER) > 0.95


def test_a_large_shirt_with_a_print_is_no_table() -> None:
    shirt = np.array(
        [[190, 40], [450, 40], [520, 110], [480, 150], [450, 130], [455, 450], [185, 450], [190, 130]]
    )
    picture = photograph(shape=shirt, cloth=(35, 35, 45), table=(200, 180, 90), grain=8)
    cv2.ellipse(picture, (360, 160), (48, 30), 20, 0, 360, (230, 60, 50), cv2.FILLED)
    assert filled(shirt).mean() > OutlineParameters().candidates.whole_table_share
    assert iou(find_outline(picture).points, shirt.astype(float)) > 0.96


def test_garment_too_small() -> None:
    mask = np.zeros((200, 200), bool)
    mask[90:110, 90:110] = True
    with pytest.raises(GarmentTooSmallError, match="at least 600"):
        find_outline(mask)
    assert len(find_outline(mask, parameters=replace(OutlineParameters(), least_pixels=300)).points) > 60
    for shape in [(10, 10, 3), (600, 20, 3), (1, 1, 3)]:
        with pytest.raises(GarmentTooSmallError, match="too small"):
            find_outline(np.random.default_rng(0).integers(0, 255, shape).astype(np.uint8))


def test_masks_stand_in_for_the_segmentation(tmp_path: Path) -> None:
    picture, mask = photograph(), filled(PULLOVER)
    Image.fromarray(picture).save(tmp_path / "photo.png")
    Image.fromarray((mask * 255).astype(np.uint8)).save(tmp_path / "mask.png")
    want = find_outline(mask)
    assert want.rgb is None
    for source in (picture, tmp_path / "photo.png", str(tmp_path / "photo.png")):
        for given_mask in (mask, mask * 255, tmp_path / "mask.png", str(tmp_path / "mask.png")):
            found = find_outline(source, mask=given_mask)
            assert np.array_equal(found.points, want.points)
            assert np.array_equal(found.mask, mask)
            assert np.array_equal(found.rgb, picture)


def test_masks_that_do_not_fit_are_refused() -> None:
    picture, mask = photograph(), filled(PULLOVER)
    with pytest.raises(OutlineError, match="639 x 480"):
        find_outline(picture, mask=mask[:, :-1])
    with pytest.raises(NoGarmentError, match="empty"):
        find_outline(picture, mask=np.zeros_like(mask))
    with pytest.raises(OutlineError, match="source is a mask"):
        find_outline(mask, mask=mask)
    with pytest.raises(OutlineError, match="source is an outline"):
        find_outline(PULLOVER, mask=mask)
    with pytest.raises(NotAnImageError, match="shape"):
        find_outline(picture, mask=PULLOVER[0])


def test_threads_in_a_mask_do_not_make_the_outline_cross_itself() -> None:
    mask = filled(PULLOVER)
    mask[300, 400:600] = True
    mask[60:200, 330] = True
    outline = outline_of_mask(mask)
    assert Polygon(outline).is_valid
    assert iou(outline, PULLOVER) > 0.98
    threads = np.zeros_like(mask)
    threads[::40] = True
    with pytest.raises(GarmentTooSmallError, match="0 pixels"):
        outline_of_mask(threads)


def test_several_objects_and_holes_in_a_mask() -> None:
    mask = filled(PULLOVER)
    mask[200:260, 300:350] = False
    mask[10:20, 10:20] = True
    assert iou(outline_of_mask(mask), PULLOVER) > 0.98
    two = filled(PULLOVER / 2) | filled(PULLOVER / 2 + [300, 0])
    with pytest.raises(SeveralGarmentsError, match="several"):
        outline_of_mask(two)


@given(
    st.integers(40, 90),
    st.integers(30, 90),
    st.floats(0, np.pi),
    st.sampled_from(["C", "F", "reversed", "uint8"]),
)
def test_outline_of_a_mask_gives_the_mask_back(width: int, height: int, turn: float, layout: str) -> None:
    corners = np.array([[-1, -1], [1, -1], [1, 1], [0, 0.2], [-1, 1]]) * [width, height]
    turned = corners @ [[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]] + [160, 150]
    mask = filled(turned, (300, 320))
    array = {
        "C": mask,
        "F": np.asfortranarray(mask),
        "reversed": mask[::-1, ::-1].copy()[::-1, ::-1],
        "uint8": mask.astype(np.uint8) * 255,
    }[layout]
    outline = outline_of_mask(array)
    assert outline.dtype == np.float64
    assert Polygon(outline).is_valid
    back = filled(outline, mask.shape)
    assert (back & mask).sum() / (back | mask).sum() > 0.98
    assert np.abs(outline.mean(axis=0) - turned.mean(axis=0)).max() < max(width, height)


@given(st.sampled_from(["C", "F", "reversed", "strided", "opencv", "list", "float32", "int32", "closed"]))
def test_points_of_any_layout(layout: str) -> None:
    points = {
        "C": PULLOVER,
        "F": np.asfortranarray(PULLOVER),
        "reversed": PULLOVER[::-1].copy()[::-1],
        "strided": np.repeat(PULLOVER, 2, axis=0)[::2],
        "opencv": PULLOVER.astype(np.int32)[:, None],
        "list": PULLOVER.tolist(),
        "float32": PULLOVER.astype(np.float32),
        "int32": PULLOVER.astype(np.int32),
        "closed": np.concatenate([PULLOVER, PULLOVER[:1]]),
    }[layout]
    found = find_outline(points)
    assert np.array_equal(found.points, PULLOVER)
    assert found.points.dtype == np.float64
    assert found.points.flags.c_contiguous
    assert not np.shares_memory(found.points, points if isinstance(points, np.ndarray) else PULLOVER)
    assert found.rgb is None
    assert found.mask is None


@pytest.mark.parametrize(
    ("points", "words"),
    [
        (PULLOVER[:2], "2 points"),
        (PULLOVER[[0, 1, 0]], "2 points"),
        (np.zeros((0, 2)), "0 points"),
        (np.where(PULLOVER == 110, np.nan, PULLOVER), "NaN"),
        (np.where(PULLOVER == 110, np.inf, PULLOVER), "infinity"),
        (PULLOVER * 1j, "complex"),
        (PULLOVER.T, "shape"),
        ([[0, 0], [1]], "numbers"),
        ([["a", "b"]] * 3, "numbers"),
    ],
)
def test_points_that_are_no_outline(points: object, words: str) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(InvalidOutlineError, match=words):
            as_outline(points)


def test_an_image_of_pillow_is_a_photograph(tmp_path: Path) -> None:
    """Whatever its mode: black and white ones are no masks, and narrow ones no points."""
    picture = np.full((120, 160), 255, np.uint8)
    picture[30:90, 40:120] = 0
    black_and_white = Image.fromarray(picture).convert("1")
    black_and_white.save(tmp_path / "a.png")
    want = find_outline(tmp_path / "a.png")
    found = find_outline(black_and_white)
    assert found.rgb is not None
    assert np.array_equal(found.points, want.points)
    assert np.array_equal(as_photograph(black_and_white), want.rgb)


@pytest.mark.parametrize("dtype", [np.uint8, np.int64])
def test_a_mask_of_0_and_1_as_the_source_is_told_what_it_must_be(dtype: type, tmp_path: Path) -> None:
    mask = np.zeros((120, 160), dtype)
    mask[30:90, 40:120] = 1
    Image.fromarray(mask.astype(np.uint8)).save(tmp_path / "mask.png")
    for source in (mask, tmp_path / "mask.png", str(tmp_path / "mask.png")):
        with pytest.raises(NoGarmentError, match="booleans, or of 0 and 255"):
            find_outline(source)
    assert np.array_equal(find_outline(mask, mask=mask).points, find_outline(mask > 0).points)


@pytest.mark.parametrize(
    "points",
    [
        [],
        [[0, 384, 384, 0], [0, 0, 100, 100]],
        [[0, 0, 1], [384, 0, 1], [384, 100, 1], [0, 100, 1]],
        [[0.5], [1.5]],
    ],
)
def test_points_of_another_shape_are_told_that_of_an_outline(points: list[list[float]]) -> None:
    with pytest.raises(InvalidOutlineError, match=r"an outline has the shape \(n, 2\)"):
        find_outline(points)


def test_an_empty_path_and_a_url_are_told_as_such() -> None:
    with pytest.raises(ImageNotFoundError, match="path is empty"):
        find_outline("")
    with pytest.raises(ImageNotFoundError, match="is a URL, which is not read"):
        find_outline("https://example.com/a.jpg")


def test_a_photograph_for_the_table_is_refused_undecoded_if_it_is_too_large(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    picture = photograph()
    cv2.imwrite(str(tmp_path / "a.png"), picture)
    pixels = WIDTH * HEIGHT
    assert as_photograph(tmp_path / "a.png", pixels) is not None
    parameters = Parameters(outline=OutlineParameters(max_pixels=pixels - 1))
    depth, table = np.ones((HEIGHT, WIDTH)), TablePlane(np.diag([0.1, 0.1, 1.0]))
    monkeypatch.setattr(cv2, "imdecode", lambda *_: pytest.fail("it was decoded"))
    known: dict[str, object]
    for known in ({"depth": depth}, {"table": Sheet()}, {"table": Marker(5.0)}, {"table": table}):
        for source in (tmp_path / "a.png", picture):
            with pytest.raises(ImageTooLargeError, match="640 x 480"):
                fit(source, parameters=parameters, **known)
