"""scenes/calibration: boards for calibrating cameras, of exactly known geometry, at several poses.

Squares are geometry, not a texture: their corners are where the numbers below say, at any distance. All lengths are
multiples of 2^-16 m, so that the file holds them without rounding. All cells of a board share the corners of a grid,
so no crack can open between them.

    chequerboard   12 x 9 squares of 31.25 mm, 11 x 8 inner corners, a white margin of one square
    charuco        8 x 6 squares of 62.5 mm, markers of 46.875 mm, DICT_4X4_50 from 0 on: cv2.aruco.CharucoBoard((8, 6),
                   0.0625, 0.046875, dictionary), a white margin of half a square
"""

import cv2
import numpy as np

from .glb import Glb
from .scene import Scene

COLUMNS, ROWS, SQUARE_M = 12, 9, 1 / 32
CHARUCO_COLUMNS, CHARUCO_ROWS, CHARUCO_SQUARE_M, MODULES = 8, 6, 1 / 16, 8
CENTRE_HEIGHT_M = 1.5
# World place of the first inner corner of the board in the middle, top left as seen from the front (from -x).
FIRST_CORNER = (0.0, (COLUMNS / 2 - 1) * SQUARE_M, CENTRE_HEIGHT_M + (ROWS / 2 - 1) * SQUARE_M)


def chequer_cells():
    """True where black; rows from the top, with the margin."""
    cells = np.zeros((ROWS + 2, COLUMNS + 2), dtype=bool)
    row, column = np.indices((ROWS, COLUMNS))
    cells[1:-1, 1:-1] = (row + column) % 2 == 0
    return cells


def charuco_cells():
    """The same for the ChArUco board, MODULES cells a square: a marker is 6 of 8 modules wide."""
    dictionary = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_50)
    size = (CHARUCO_ROWS * MODULES, CHARUCO_COLUMNS * MODULES)
    cells, marker = np.zeros(size, dtype=bool), 0
    for row in range(CHARUCO_ROWS):
        for column in range(CHARUCO_COLUMNS):
            y, x = row * MODULES, column * MODULES
            if (row + column) % 2 == 0:
                cells[y : y + MODULES, x : x + MODULES] = True
                continue
            picture = cv2.aruco.generateImageMarker(dictionary, marker, 6, borderBits=1)
            cells[y + 1 : y + 7, x + 1 : x + 7] = picture < 128
            marker += 1
    return np.pad(cells, MODULES // 2)


def board_mesh(cells, cell_m, black):
    """Triangles of all black or all white cells, facing +z, the middle of the board at the origin."""
    rows, columns = cells.shape
    x, y = np.meshgrid((np.arange(columns + 1) - columns / 2) * cell_m, (rows / 2 - np.arange(rows + 1)) * cell_m)
    positions = np.stack([x, y, np.zeros_like(x)], axis=-1).reshape(-1, 3)
    row, column = np.nonzero(cells == black)
    a = (row + 1) * (columns + 1) + column  # bottom left
    b, c, d = a + 1, a - columns, a - columns - 1
    return positions, np.stack([np.stack([a, b, c], 1), np.stack([a, c, d], 1)], 1).reshape(-1, 3)


def _board(name, cells, cell_m):
    glb = Glb(name, extras={"cell_m": cell_m, "cells": list(cells.shape[::-1])})
    parts = []
    for ink, base, black in (("white", 0.85, False), ("black", 0.02, True)):
        material = glb.material(ink, base=(base, base, base), unlit=True)
        positions, triangles = board_mesh(cells, cell_m, black)
        normals = np.tile([0.0, 0, 1], (len(positions), 1))
        parts.append(glb.primitive(positions, normals, triangles, material))
    glb.node(name, mesh=glb.mesh(name, parts))
    return glb.bytes()


def files():
    scene = Scene("calibration", "Chequered and ChArUco boards of exactly known geometry, at several poses.", seed=1)
    scene.environment(background=(0.18, 0.2, 0.22), sky=(1, 1, 1), ground=(1, 1, 1))
    scene.model("chequerboard", "calibration/chequerboard.glb")
    scene.model("charuco", "calibration/charuco.glb")
    # With yaw 0 a board faces -y; at -90 degrees it faces -x.
    scene.object("board", "chequerboard", "board", (0, 0, CENTRE_HEIGHT_M), -90)
    scene.object("board_left", "chequerboard", "board", (-0.25, 0.75, CENTRE_HEIGHT_M), -60)
    scene.object("board_right", "chequerboard", "board", (-0.25, -0.75, CENTRE_HEIGHT_M), -120)
    scene.object("board_far", "chequerboard", "board", (2, 0, 2.25), -90)
    scene.object("charuco", "charuco", "board", (0.5, 0, 0.75), -90)
    scene.place("front", "straight in front of the board in the middle", (-0.75, 0, CENTRE_HEIGHT_M), (0, 0, CENTRE_HEIGHT_M), 45)
    scene.place("left", "from the left, 12 cm beside right", (-0.75, 0.06, 1.6), (0, 0, 1.45), 50)
    scene.place("right", "from the right, 12 cm beside left", (-0.75, -0.06, 1.6), (0, 0, 1.45), 50)
    scene.place("all", "all boards", (-2.5, 0, 1.75), (0, 0, 1.4), 50)
    scene.camera("front", "front", (640, 480), 25)
    scene.camera("all", "all", (640, 480), 25)
    return {
        "calibration.json": scene.text(),
        "calibration/chequerboard.glb": _board("chequerboard", chequer_cells(), SQUARE_M),
        "calibration/charuco.glb": _board("charuco", charuco_cells(), CHARUCO_SQUARE_M / MODULES),
    }
