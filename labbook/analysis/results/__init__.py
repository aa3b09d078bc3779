"""Results as they are stored, under the fingerprint of what they were computed from."""
