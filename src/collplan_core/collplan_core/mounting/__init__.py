"""How a LIDAR is mounted, stamped and swept, from scans of a moving robot that must agree with one another."""
