#!/usr/bin/env python3
"""Checks a bus.yml of ros2_canopen: every key must be one that a program reads. See --help.

dcfgen and ros2_canopen ignore unknown keys without a message, so a typo is a lost setting.
"""

import argparse
import difflib
import sys
from pathlib import Path

import yaml

# Read by dcfgen of dcf-tools 2.4.2 (dcfgen/cli.py); a test compares these sets with its source.
DCFGEN_OPTIONS = {"dcf_path", "heartbeat_multiplier", "retry_factor"}
DCFGEN_MASTER = {
    "baudrate", "boot_time", "emcy_inhibit_time", "error_behavior", "heartbeat_consumer", "heartbeat_multiplier",
    "heartbeat_producer", "nmt_inhibit_time", "node_id", "product_code", "reset_all_nodes", "revision_number",
    "serial_number", "start", "start_all_nodes", "start_nodes", "stop_all_nodes", "sync_overflow", "sync_period",
    "sync_window", "time_cob_id", "vendor_id",
}
DCFGEN_NODE = {
    "boot", "configuration_file", "dcf", "dcf_path", "error_behavior", "guard_time", "heartbeat_consumer",
    "heartbeat_multiplier", "heartbeat_producer", "life_time_factor", "mandatory", "node_id", "reset_communication",
    "restore_configuration", "retry_factor", "revision_number", "rpdo", "sdo", "serial_number", "software_file",
    "software_version", "time_cob_id", "tpdo",
}
DCFGEN_PDO = {
    "cob_id", "enabled", "event_deadline", "event_timer", "inhibit_time", "mapping", "sync_start", "transmission",
}
DCFGEN_MAPPING = {"index", "sub_index"}
DCFGEN_SDO = {"index", "sub_index", "value"}

# Read by ros2_canopen: canopen_core (container, drivers' base class), canopen_base_driver and canopen_402_driver
# (node_canopen_base_driver_impl.hpp, node_canopen_402_driver_impl.hpp), canopen_ros2_control; documented in its pages
# "Configuration Package" and "Cia402 Driver". namespace came with its pull request 170, remappings with 352, and
# num_channels, channel_names, channels and scale_eff_from_dev with 404 (January 2026).
ROS2_MASTER = {"driver", "namespace", "package", "remappings"}
ROS2_NODE = {
    "boot_timeout_ms", "diagnostics", "driver", "enable_lazy_load", "namespace", "non_transmit_timeout", "package", "period",
    "polling", "remappings", "sdo_timeout_ms",
}
ROS2_SCALES = {
    "offset_pos_from_dev", "offset_pos_to_dev", "scale_eff_from_dev", "scale_pos_from_dev", "scale_pos_to_dev",
    "scale_vel_from_dev", "scale_vel_to_dev",
}
ROS2_402 = ROS2_SCALES | {
    "channel_names", "channels", "homing_timeout_seconds", "num_channels", "position_mode", "switching_state",
    "torque_mode", "velocity_mode",
}
ROS2_DIAGNOSTICS = {"enable", "period"}

SECTIONS = {"options", "master", "defaults", "nodes"}


def errors(bus):
    """Errors in the content of a bus.yml, one sentence each."""
    found = []
    if not isinstance(bus, dict):
        return ["not a bus.yml: the sections options, master and nodes are missing"]
    _look(found, "the file", bus, SECTIONS)
    _look(found, "options", bus.get("options", {}), DCFGEN_OPTIONS)
    master = bus.get("master", {})
    _look(found, "master", master, DCFGEN_MASTER | ROS2_MASTER)
    nodes = bus.get("nodes", {})
    if not isinstance(nodes, dict) or not nodes:
        return [*found, "nodes: empty; expected at least one node"]
    for name, node in {"defaults": bus.get("defaults", {}), **nodes}.items():
        place = name if name == "defaults" else f"nodes/{name}"
        if _look(found, place, node, DCFGEN_NODE | ROS2_NODE | ROS2_402):
            _look_into_node(found, place, node)
    for name, node in nodes.items():
        if isinstance(node, dict) and node.get("node_id") == master.get("node_id"):
            found.append(f"nodes/{name}: node_id {node.get('node_id')} is the master's")
    return found


def _look_into_node(found, place, node):
    _look(found, f"{place}/diagnostics", node.get("diagnostics", {}), ROS2_DIAGNOSTICS)
    for number, channel in enumerate(node.get("channels", [])):
        _look(found, f"{place}/channels/{number}", channel, ROS2_SCALES)
    for number, sdo in enumerate(node.get("sdo", [])):
        _look(found, f"{place}/sdo/{number}", sdo, DCFGEN_SDO)
    for kind in ("rpdo", "tpdo"):
        for number, pdo in node.get(kind, {}).items():
            if _look(found, f"{place}/{kind}/{number}", pdo, DCFGEN_PDO):
                for position, entry in enumerate(pdo.get("mapping", [])):
                    _look(found, f"{place}/{kind}/{number}/mapping/{position}", entry, DCFGEN_MAPPING)
    names = node.get("channel_names", [])
    if len(names) != node.get("num_channels", len(names)):
        found.append(f"{place}/channel_names: {len(names)} for {node['num_channels']} channels")
    for name in names:
        if str(name).isdigit() or names.count(name) > 1:
            found.append(f"{place}/channel_names: '{name}' must be unique and not a number, because ROS names services after it")


def _look(found, place, table, known):
    """Whether `table` is a table; adds its unknown keys to `found`."""
    if not isinstance(table, dict):
        found.append(f"{place}: must be a table of keys, not {type(table).__name__}")
        return False
    for key in table:
        if key not in known:
            close = difflib.get_close_matches(str(key), known, n=1)
            found.append(f"{place}: neither dcfgen nor ros2_canopen reads '{key}'" + (f"; did you mean '{close[0]}'?" if close else ""))
    return True


def main():
    parser = argparse.ArgumentParser(
        description="Checks that dcfgen or ros2_canopen reads every key of a bus.yml. Exit code 1: unknown key; 2: the file"
        " cannot be read.")
    parser.add_argument("file", type=Path)
    file = parser.parse_args().file
    try:
        found = errors(yaml.safe_load(file.read_text(encoding="utf-8")))
    except (OSError, UnicodeDecodeError, yaml.YAMLError) as error:
        print(f"check_bus: {file}: {' '.join(str(error).split())}", file=sys.stderr)
        return 2
    for line in found:
        print(f"{file}: {line}.", file=sys.stderr)
    if not found:
        print(f"{file}: all keys are known.")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
