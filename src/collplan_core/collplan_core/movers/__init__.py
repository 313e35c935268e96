"""What moves around the robot: found in scans, predicted, and kept from being driven into."""
