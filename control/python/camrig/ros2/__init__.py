"""ROS 2 without a node: files for its camera drivers, and rosbag2 recordings (`camrig ros2`).

See docs/ros2.md. Nothing here needs ROS; recording needs the packages of the extra: pip install 'camrig[ros2]'.
"""
