# PyMOL on one scene of spheres and sticks, in the window of an X display.
#
# pymol_spheres_child.py gl|ray SCENE MASK EYE(3) TARGET(3) UP(3) FOV WIDTH HEIGHT REPEATS
# As vtk_spheres_child.cpp; gl is PyMOL's OpenGL with its shaders of impostors, ray its ray tracer
# with shadows. Both draw CGOs: as fast as atoms and bonds, which become the same impostors.
# SPDX-License-Identifier: MPL-2.0
import statistics
import sys
import time

import numpy as np
import pymol
import pymol2
from OpenGL import GL
from PyQt5.QtCore import Qt
from PyQt5.QtGui import QGuiApplication, QImage, QOpenGLContext, QSurface, QSurfaceFormat, QWindow
from pymol import cgo

how, scene_file, mask_file = sys.argv[1:4]
numbers = np.array(sys.argv[4:], float)
eye, target, up = numbers[:9].reshape(3, 3)
fov = numbers[9]
width, height, repeats = numbers[10:].astype(int).tolist()

with open(scene_file, "rb") as file:
    counts = np.fromfile(file, np.int32, 2)
    spheres = np.fromfile(file, np.float32, 7 * counts[0]).reshape(-1, 7)
    sticks = np.fromfile(file, np.float32, 10 * counts[1]).reshape(-1, 10)


def encoded(linear):
    return linear ** (1 / 2.2)


def column(number, rows):
    return np.full((len(rows), 1), number)


# A context of our own, so that a frame is drawn when and only when it is timed.
application = QGuiApplication(sys.argv)
form = QSurfaceFormat()
form.setDepthBufferSize(24)
form.setProfile(QSurfaceFormat.CompatibilityProfile)
QSurfaceFormat.setDefaultFormat(form)
window = QWindow()
window.setSurfaceType(QSurface.OpenGLSurface)
window.setFlags(Qt.FramelessWindowHint)
window.setGeometry(0, 0, width, height)
window.show()
application.processEvents()
context = QOpenGLContext()
if not context.create() or not context.makeCurrent(window):
    sys.exit("pymol_spheres_child: no OpenGL")

pymol.invocation.parse_args(["pymol", "-q"])
instance = pymol2.PyMOL()
instance.start()
cmd = instance.cmd
for name in ("internal_gui", "internal_feedback", "depth_cue", "antialias",
             "ray_opaque_background"):
    cmd.set(name, 0)
cmd.set("max_threads", 2)  # of ray, as many as of the software rasteriser
instance.reshape(width, height, 1)
instance.draw()  # finds the shaders
cmd.bg_color("white")
balls = [column(cgo.COLOR, spheres), encoded(spheres[:, 4:]), column(cgo.SPHERE, spheres),
         spheres[:, :4]]
# The two halves of a bond are one cylinder of two colours, as PyMOL draws its own.
halves, others = sticks[::2], sticks[1::2]
if not np.array_equal(halves[:, 3:7], others[:, 3:7]):
    sys.exit("pymol_spheres_child: sticks are not in pairs that meet")
no_caps = column(0, halves)
bonds = [column(cgo.CUSTOM_CYLINDER, halves), halves[:, :3], others[:, :3], halves[:, 6:7],
         encoded(halves[:, 7:]), encoded(others[:, 7:]), no_caps, no_caps]
cmd.load_cgo(np.hstack(balls).ravel().tolist() + np.hstack(bonds).ravel().tolist(), "scene",
             zoom=0)

points = np.vstack([spheres[:, :3], sticks[:, :3]])
radii = np.hstack([spheres[:, 3], sticks[:, 6]])


def look_from(eye):
    back = eye - target
    distance = np.linalg.norm(back)
    back /= distance
    right = np.cross(up, back)
    right /= np.linalg.norm(right)
    depths = (eye - points) @ back
    near, far = (depths - radii).min(), (depths + radii).max()
    # Column by column; a negative field of view is a perspective one.
    columns = np.array([right, np.cross(back, right), back]).T
    cmd.set_view([*columns.ravel(), 0, 0, -distance, *target, 0.99 * near, 1.01 * far, -fov])


def draw(frame):
    """Seconds of a frame and its reading; the eye moves a little each time, as ours does."""
    look_from(eye + [1e-3 * frame, 0, 0])
    start = time.perf_counter()
    if how == "ray":
        cmd.ray(width, height)
    else:
        instance.draw()
        GL.glReadPixels(0, 0, width, height, GL.GL_RGB, GL.GL_UNSIGNED_BYTE)
    return time.perf_counter() - start


seconds = []
if how == "ray":
    seconds.append(draw(0))
    picture = QImage.fromData(cmd.png(None)).convertToFormat(QImage.Format_RGBA8888)
    pixels = np.frombuffer(picture.constBits().asarray(picture.byteCount()), np.uint8)
    covered = pixels.reshape(height, width, 4)[:, :, 3] > 0
    note = "one frame with shadows, %s threads" % cmd.get("max_threads")
else:
    draw(0)
    depths = np.frombuffer(
        GL.glReadPixels(0, 0, width, height, GL.GL_DEPTH_COMPONENT, GL.GL_FLOAT), np.float32)
    covered = depths.reshape(height, width)[::-1] < 1  # GL's rows begin at the bottom
    seconds += [draw(1 + frame) for frame in range(repeats)]
    note = GL.glGetString(GL.GL_RENDERER).decode()
with open(mask_file, "wb") as file:
    file.write(b"P5\n%d %d\n255\n" % (width, height) + covered.astype(np.uint8).tobytes())
print("peer_child: %.6f %s" % (statistics.median(seconds), note), flush=True)
