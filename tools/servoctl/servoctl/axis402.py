# SPDX-License-Identifier: Apache-2.0
"""A CiA 402 axis at an offset of 0x800 for python-canopen, whose own BaseNode402 supports only the first axis.

    network.add_node(azimuth := BaseNode402(1, "trackservo.eds"))
    pitch = Axis402(1, "trackservo.eds", axis=1, beside=azimuth)
    pitch.setup_402_state_machine()
    pitch.op_mode = "PROFILED VELOCITY"
    pitch.state = "OPERATION ENABLED"

Everything of BaseNode402 works with the indices of the first axis (0x6041 is this axis' statusword); objects outside
0x6000 to 0x67FF belong to the node.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from canopen.node.remote import RemoteNode
from canopen.objectdictionary import ObjectDictionary
from canopen.pdo import PdoMap
from canopen.profiles.p402 import BaseNode402
from canopen.sdo.base import SdoArray, SdoRecord, SdoVariable
from canopen.sdo.client import SdoClient

from .objects.parameter import AXIS_SHIFT

_FIRST, _BEYOND = 0x6000, 0x6800


class ShiftedSdo:
    """An SDO client that reads 0x6000 to 0x67FF as the objects of another axis; everything else passes through."""

    def __init__(self, client: SdoClient, shift: int) -> None:
        self._client = client
        self._shift = shift

    def _index(self, index: int) -> int:
        return index + self._shift if _FIRST <= index < _BEYOND else index

    def _key(self, index: int | str) -> int | str:
        return self._index(index) if isinstance(index, int) else index

    def __getitem__(self, index: int | str) -> SdoVariable | SdoArray | SdoRecord:
        return self._client[self._key(index)]

    def __contains__(self, index: int | str) -> bool:
        return self._key(index) in self._client

    def __iter__(self) -> Iterator[int]:
        shift = self._shift
        for index in self._client:
            if not _FIRST <= index < _BEYOND:
                yield index - shift if _FIRST <= index - shift < _BEYOND else index

    def keys(self) -> list[int]:
        """Indices as this axis sees them."""
        return list(self)

    def upload(self, index: int, subindex: int) -> bytes:
        """As SdoClient, shifted."""
        return bytes(self._client.upload(self._index(index), subindex))

    def download(self, index: int, subindex: int, data: bytes, **options: Any) -> None:
        """As SdoClient, shifted."""
        self._client.download(self._index(index), subindex, data, **options)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._client, name)


class Axis402(BaseNode402):
    """One axis of a node with several; `axis` counts from 0.

    `beside` is a node with the same id that is in a network already: its network and SDO channel are shared. Without
    it, add this one to a network as any node.
    """

    def __init__(
        self, node_id: int, object_dictionary: ObjectDictionary | str, axis: int = 1, beside: RemoteNode | None = None
    ) -> None:
        self.shift = AXIS_SHIFT * axis
        self._beside = beside
        super().__init__(node_id, object_dictionary)  # type: ignore[no-untyped-call]
        if beside is not None:
            if beside.id != self.id:
                raise ValueError(f"node {self.id} cannot be beside node {beside.id}: both must have the same id")
            self.associate_network(beside.network)

    def add_sdo(self, rx_cobid: int, tx_cobid: int) -> ShiftedSdo:
        """Called while BaseNode402 is made, before its PDOs get the client."""
        if self._beside is not None:
            return ShiftedSdo(self._beside.sdo, self.shift)
        return ShiftedSdo(super().add_sdo(rx_cobid, tx_cobid), self.shift)  # type: ignore[no-untyped-call]

    def associate_network(self, network: Any) -> None:
        """Joins; network.add_node calls it too."""
        super().associate_network(network)
        for channel in self.sdo_channels:
            channel.network = network

    def leave(self) -> None:
        """Leaves the network of the node beside; not needed before the network is disconnected."""
        self.remove_network()

    def _own_index(self, index: int) -> int | None:
        """The first axis' index of an object of this axis, None for one of another axis, otherwise the index."""
        if _FIRST <= index - self.shift < _BEYOND:
            return index - self.shift
        return None if _FIRST <= index < 0xA000 else index

    def _init_tpdo_values(self) -> None:
        for tpdo in self.tpdo.values():
            if tpdo.enabled:
                tpdo.add_callback(self.on_TPDOs_update_callback)
                for variable in tpdo:
                    index = self._own_index(variable.index)
                    if index is not None and index not in self.tpdo_values:
                        self.tpdo_values[index] = 0
                        self.tpdo_pointers[index] = variable

    def _init_rpdo_pointers(self) -> None:
        for rpdo in self.rpdo.values():
            if rpdo.enabled:
                for variable in rpdo:
                    index = self._own_index(variable.index)
                    if index is not None and index not in self.rpdo_pointers:
                        self.rpdo_pointers[index] = variable

    def on_TPDOs_update_callback(self, mapobject: PdoMap) -> None:
        """Keeps the values of this axis' objects."""
        for variable in mapobject:
            index = self._own_index(variable.index)
            if index is not None:
                self.tpdo_values[index] = variable.raw
