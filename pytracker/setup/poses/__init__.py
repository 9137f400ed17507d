"""A body's first pose: from `keypoints` of a `person`, or from the `outline` and skin; either by a `fit`."""
