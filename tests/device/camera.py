"""A camera of this computer: its frames reach the node by RPDO4, as in docs/can.md."""

CAMERA_ID = 0x541
TRACKING = -1
ON_TARGET, COASTING, LOST = 3, 4, 5


def map_camera(master):
    """RPDO4 takes its frames; the axes turn on while the client is silent. The node is operational."""
    sdo = master.node.sdo
    sdo[0x1403][1].raw = 0x80000000 | CAMERA_ID
    sdo[0x1603][0].raw = 0
    for sub, bits in enumerate((16, 16, 16, 8, 8), start=1):
        sdo[0x1603][sub].raw = 0x3070 << 16 | sub << 8 | bits
    sdo[0x1603][0].raw = 5
    sdo[0x1403][1].raw = CAMERA_ID
    for index in (0x6007, 0x6807):
        sdo[index].raw = 0
    master.start()
