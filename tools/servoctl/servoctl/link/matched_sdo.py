# SPDX-License-Identifier: Apache-2.0
"""An SDO client that takes no answer to another request as its own.

An answer to a request that timed out, or to one of another program on this computer, can arrive after our request was sent.
The SdoClient of canopen takes the first answer that comes.
"""

from __future__ import annotations

import queue
import time

import canopen
from canopen.sdo.client import SdoClient
from canopen.sdo.exceptions import SdoAbortedError, SdoCommunicationError

SPECIFIER = 0xE0
"""Bits of the first byte of a frame that give its kind (CiA 301)."""
ABORT = 0x80
ANSWERS = {0x40: 0x40, 0x20: 0x60, 0x60: 0x00, 0x00: 0x20, 0xA0: 0xC0, 0xC0: 0xA0}
"""Kind of the answer to upload, download, a segment of each, block upload and block download."""
BEGIN, BEGIN_BLOCK, BLOCK_PART = (0x40, 0x20), (0xA0, 0xC0), 0x03
"""Requests that name their object, as their answers do; those of blocks if the bits BLOCK_PART are 0."""
TIMED_OUT = 0x05040000
COMPETING = 0x08000020
"""With this code the node refuses all clients that compete for it, and names the object of one of them."""


class MatchedSdo(SdoClient):
    """Skips answers of another kind and answers that name another object."""

    _object = bytes(3)
    """Index and sub-index of the transfer, as in its frames."""

    def request_response(self, sdo_request: bytes) -> bytes:
        """Raises SdoCommunicationError when no answer comes within RESPONSE_TIMEOUT, SdoAbortedError for a refusal."""
        request = bytes(sdo_request)
        kind = request[0] & SPECIFIER
        begins = kind in BEGIN or (kind in BEGIN_BLOCK and not request[0] & BLOCK_PART)
        if begins:
            self._object = request[1:4]
        self.responses = queue.Queue()
        self.send_request(request)  # type: ignore[no-untyped-call]
        end = time.monotonic() + self.RESPONSE_TIMEOUT
        while True:
            try:
                answer: bytes = self.responses.get(timeout=max(0.0, end - time.monotonic()))
            except queue.Empty:
                self.abort(TIMED_OUT)  # type: ignore[no-untyped-call]
                raise SdoCommunicationError("No SDO response received") from None
            ours = answer[1:4] == self._object
            if answer[0] == ABORT:
                code = int.from_bytes(answer[4:8], "little")
                if ours or code == COMPETING:
                    raise SdoAbortedError(code)
            elif answer[0] & SPECIFIER == ANSWERS[kind] and (ours or not begins):
                return answer


class MatchedNode(canopen.RemoteNode):
    """A node with this client."""

    def add_sdo(self, rx_cobid: int, tx_cobid: int) -> MatchedSdo:
        """Called while RemoteNode is made."""
        client = MatchedSdo(rx_cobid, tx_cobid, self.object_dictionary)  # type: ignore[no-untyped-call]
        self.sdo_channels.append(client)
        return client
