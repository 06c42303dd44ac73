"""A ROS 2 node: explains every picture asked for, publishes landmarks and the poses of the best grasp pair.

python foldrs_node.py --ros-args -r image:=/camera/image_rect -r camera_info:=/camera/camera_info

The picture must be undistorted (image_proc makes `image_rect`). The table's frame comes from tf: its xy plane
is the table, its z axis up. Pictures are explained when the service `explain` is called, not at the camera's
rate: the garment lies still, and a fit takes a second.
"""

from __future__ import annotations

import json

import numpy as np
import rclpy
from geometry_msgs.msg import Pose, PoseArray
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from rclpy.time import Time
from sensor_msgs.msg import CameraInfo, Image
from std_msgs.msg import String
from std_srvs.srv import Trigger
from table_view import TableView, grasp_pose, picture_of, rotation_of
from tf2_ros import Buffer, TransformException, TransformListener
from visualization_msgs.msg import Marker, MarkerArray

import foldrs
from foldrs.errors import FoldrsError


class FoldrsNode(Node):
    """Keeps the newest picture; explains it on request."""

    def __init__(self) -> None:
        super().__init__("foldrs")
        self.declare_parameter("table_frame", "table")
        self.declare_parameter("window_corner", [-0.6, -0.6])  # least x and y on the table, m
        self.declare_parameter("window_size", [1.2, 1.2])  # m
        self.declare_parameter("garment_type", "")  # empty: any
        self.picture: Image | None = None
        self.camera_info: CameraInfo | None = None
        self.transforms = Buffer()
        self.listener = TransformListener(self.transforms, self)
        self.create_subscription(Image, "image", self.keep_picture, qos_profile_sensor_data)
        self.create_subscription(CameraInfo, "camera_info", self.keep_camera_info, qos_profile_sensor_data)
        self.poses = self.create_publisher(PoseArray, "grasp_poses", 1)
        self.markers = self.create_publisher(MarkerArray, "landmarks", 1)
        self.results = self.create_publisher(String, "result", 1)
        self.create_service(Trigger, "explain", self.explain)

    def keep_picture(self, message: Image) -> None:
        """Keep the newest picture."""
        self.picture = message

    def keep_camera_info(self, message: CameraInfo) -> None:
        """Keep the newest calibration."""
        self.camera_info = message

    def explain(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        """Explain the newest picture; what went wrong is told in the response."""
        try:
            view, picture = self.view_of_table()
            kind = self.get_parameter("garment_type").value or None
            result = foldrs.fit(view.of(picture), garment_type=kind, px_per_cm=view.px_per_cm)
        except (FoldrsError, TransformException, ValueError) as error:
            response.success, response.message = False, str(error)
            return response
        self.publish(result, view)
        response.success = result.accepted and bool(result.grasp_pairs)
        response.message = f"{result.garment_type}, {result.alternatives[0].probability:.0%} sure"
        return response

    def view_of_table(self) -> tuple[TableView, np.ndarray]:
        """Return the table as seen from above, and the newest picture."""
        if self.picture is None or self.camera_info is None:
            raise ValueError("no picture or no camera_info has come yet: check the topics")
        message = self.picture
        found = self.transforms.lookup_transform(
            message.header.frame_id, self.get_parameter("table_frame").value, Time()
        ).transform
        view = TableView(
            camera=np.reshape(self.camera_info.p, (3, 4))[:, :3],
            rotation=rotation_of((found.rotation.x, found.rotation.y, found.rotation.z, found.rotation.w)),
            translation=np.array([found.translation.x, found.translation.y, found.translation.z]),
            corner=np.array(self.get_parameter("window_corner").value),
            size=np.array(self.get_parameter("window_size").value),
        )
        picture = picture_of(
            message.encoding, message.height, message.width, message.step, bytes(message.data)
        )
        return view, picture

    def publish(self, result: foldrs.FitResult, view: TableView) -> None:
        """Publish the result as JSON, its landmarks, and the poses of the best grasp pair (empty if none)."""
        frame = self.get_parameter("table_frame").value
        self.results.publish(String(data=json.dumps(result.to_dict())))

        poses = PoseArray()
        poses.header.frame_id = frame
        poses.header.stamp = self.picture.header.stamp
        if result.accepted and result.grasp_pairs:
            middle = view.to_table(result.outline_image).mean(axis=0)
            for point in view.to_table(result.grasp_pairs[0].image):
                position, turn = grasp_pose(point, middle - point)
                pose = Pose()
                pose.position.x, pose.position.y, pose.position.z = position.tolist()
                (pose.orientation.x, pose.orientation.y, pose.orientation.z, pose.orientation.w) = (
                    turn.tolist()
                )
                poses.poses.append(pose)
        self.poses.publish(poses)

        marks = MarkerArray()
        for number, (name, landmark) in enumerate(result.landmarks.items()):
            mark = Marker(ns="landmarks", id=number, type=Marker.TEXT_VIEW_FACING, text=name)
            mark.header = poses.header
            x, y = view.to_table(landmark.image[None])[0].tolist()
            mark.pose.position.x, mark.pose.position.y, mark.pose.position.z = x, y, 0.02
            mark.scale.z = 0.03
            mark.color.r, mark.color.g, mark.color.a = float(not landmark.accessible), 0.8, 1.0
            marks.markers.append(mark)
        self.markers.publish(marks)


def main() -> None:
    """Run until stopped."""
    rclpy.init()
    node = FoldrsNode()
    try:
        rclpy.spin(node)
    except KeyboardInterrupt:
        pass
    finally:
        node.destroy_node()
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
