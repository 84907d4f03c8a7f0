# SPDX-License-Identifier: Apache-2.0
"""What is in a node: its objects by name, its faults, its lock, and the journal of writes."""
