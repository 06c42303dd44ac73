"""Where the table lies before the camera: from image px to centimetres on it, and to a robot's frame.

One module a concept: :mod:`~foldrs.camera.pinhole` (the camera and its lens), :mod:`~foldrs.camera.plane`
(the table), :mod:`~foldrs.camera.view` (the view from above that the method works in),
:mod:`~foldrs.camera.frames` (results on the table and in a robot's frame) and :mod:`~foldrs.camera.files`
(reading all of it).

==================== ======================================================================================
image                px of the photograph, (x, y) with y down, an integer is the centre of a pixel
table                cm in the plane of the table, origin and directions as the calibration has them
camera               metres, x right, y down, z forward, as OpenCV and ROS have it
robot base           metres, as the robot has it
==================== ======================================================================================
"""

from foldrs.camera.files import load_camera, load_homography, load_pose
from foldrs.camera.frames import PairInFrame, ResultInFrame
from foldrs.camera.pinhole import Camera
from foldrs.camera.plane import TablePlane
from foldrs.camera.pose import Pose
from foldrs.camera.view import ViewFromAbove

__all__ = [
    "Camera",
    "PairInFrame",
    "Pose",
    "ResultInFrame",
    "TablePlane",
    "ViewFromAbove",
    "load_camera",
    "load_homography",
    "load_pose",
]
