"""read_code: on strips drawn from the documentation, and on one that the rig's own code drew."""

from pathlib import Path

import cv2
import numpy as np
import pytest

import camrig
from strip_drawing import crc16, draw

CODES = [(0, 0, 0), (1, 42, 1_680_000_000), (255, 2**32 - 1, 2**62), (165, 0xDEADBEEF, -1)]


def noise(width, height, seed=1, channels=3):
    shape = (height, width) if channels == 1 else (height, width, channels)
    return np.random.default_rng(seed).integers(0, 256, shape, dtype=np.uint8)


def test_the_checksum_is_the_documented_one():
    assert crc16(b"123456789") == 0x29B1


@pytest.mark.parametrize("size", [(128, 32), (129, 35), (320, 240), (640, 480), (1920, 1080), (4096, 2160)])
@pytest.mark.parametrize("code", CODES)
def test_reads_what_was_drawn(size, code):
    assert camrig.read_code(draw(noise(*size), *code)) == camrig.Code(*code)


@pytest.mark.parametrize("channels", [1, 3, 4])
def test_gray_bgr_and_bgra(channels):
    assert camrig.read_code(draw(noise(320, 240, channels=channels), *CODES[1])) == camrig.Code(*CODES[1])


@pytest.mark.parametrize("quality", [10, 50, 90])
@pytest.mark.parametrize("size", [(128, 96), (320, 240), (641, 479)])
def test_survives_jpeg(size, quality):
    for seed, code in enumerate(CODES):
        data = cv2.imencode(".jpg", draw(noise(*size, seed=seed), *code), [cv2.IMWRITE_JPEG_QUALITY, quality])[1]
        assert camrig.read_code(cv2.imdecode(data, cv2.IMREAD_COLOR)) == camrig.Code(*code)


@pytest.mark.parametrize("filter", [cv2.INTER_AREA, cv2.INTER_LINEAR, cv2.INTER_CUBIC])
@pytest.mark.parametrize(
    ("size", "scaled"),
    [
        ((640, 480), (320, 240)),
        ((1270, 720), (635, 360)),
        ((1920, 1080), (1280, 720)),
        ((640, 480), (1000, 750)),
        ((128, 96), (256, 192)),
        ((128, 96), (192, 144)),
        ((256, 192), (128, 96)),
    ],
)
def test_survives_scaling(size, scaled, filter):
    for code in CODES:
        image = cv2.resize(draw(noise(*size), *code), scaled, interpolation=filter)
        assert camrig.read_code(image) == camrig.Code(*code)


def test_survives_limited_range_and_dim_pictures():
    image = draw(noise(640, 480), *CODES[1])
    assert camrig.read_code((image * (219 / 255) + 16).astype(np.uint8)) == camrig.Code(*CODES[1])
    assert camrig.read_code((image * 0.3 + 90).astype(np.uint8)) == camrig.Code(*CODES[1])


def test_pictures_without_a_strip_give_none():
    for seed in range(20):
        assert camrig.read_code(noise(320, 240, seed)) is None
    for code in (0, 128, 255):
        assert camrig.read_code(np.full((480, 640, 3), code, np.uint8)) is None
    assert camrig.read_code(noise(16, 16)) is None
    assert camrig.read_code(np.zeros((0, 0, 3), np.uint8)) is None


def test_a_damaged_strip_is_never_read_wrongly():
    code = camrig.Code(*CODES[1])
    for bit in (*range(8, 128, 9), 31, 63, 95, 127):
        image = draw(noise(320, 240), *CODES[1])
        y, x = divmod(bit, 32)
        image[4 * y : 4 * y + 4, 4 * x : 4 * x + 4] ^= 255
        assert camrig.read_code(image) in (None, code)


def test_what_is_no_picture_is_a_type_error():
    with pytest.raises(TypeError):
        camrig.read_code(np.zeros((10, 10), float))


def test_reads_what_the_rig_draws():
    image = cv2.imread(str(Path(__file__).parent / "data" / "code_strip.png"))
    assert image.shape == (96, 161, 3)
    assert camrig.read_code(image) == camrig.Code(3, 123456, 987654321012)
    assert np.array_equal(draw(image.copy(), 3, 123456, 987654321012), image), "both draw the same cells"
