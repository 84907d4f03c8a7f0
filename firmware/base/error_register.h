/* SPDX-License-Identifier: Apache-2.0 */
/* The bits of the error register, object 1001h: CiA 301 v4.2.0, clause 7.5.2.2. */
#ifndef TRACKSERVO_BASE_ERROR_REGISTER_H
#define TRACKSERVO_BASE_ERROR_REGISTER_H

enum {
  ERROR_GENERIC = 0x01, /* set with each of the others */
  ERROR_CURRENT = 0x02,
  ERROR_VOLTAGE = 0x04,
  ERROR_TEMPERATURE = 0x08,
  ERROR_COMMUNICATION = 0x10,
  ERROR_PROFILE = 0x20,
  ERROR_MANUFACTURER = 0x80
};

#endif
