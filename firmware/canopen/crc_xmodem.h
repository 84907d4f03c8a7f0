/* SPDX-License-Identifier: Apache-2.0 */
/* CRC-16/XMODEM of the SDO block transfer.
 *
 * Standard: CiA 301 v4.2.0, clause 7.2.4.3.16: polynomial x^16 + x^12 + x^5 + 1, start value 0, most significant bit
 * first; the check value of "123456789" is 0x31C3. For data in pieces, pass the result of the previous call. */
#ifndef TRACKSERVO_CANOPEN_CRC_XMODEM_H
#define TRACKSERVO_CANOPEN_CRC_XMODEM_H

#include <stdint.h>

uint16_t crc_xmodem(uint16_t crc, const uint8_t *bytes, uint32_t length);

#endif
