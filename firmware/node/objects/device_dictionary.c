/* SPDX-License-Identifier: Apache-2.0 */
#include "node/objects/device_dictionary.h"

#include "canopen/cob_id.h"
#include "canopen/communication_profile.h"
#include "canopen/object_dictionary_rows.h"

#define PRODUCT_CODE 0x54534456 /* "TSDV" */
#define REVISION 1

#define MAP CANOPEN_MAP

/* Bus load of the defaults at 1 Mbit/s: four TPDOs every 20 ms are 2.5 %. */
#define STATE_EVENT_MS 100
#define VALUE_EVENT_MS 20
#define INHIBIT_100US 20

static const od_entry kEntries[] = {
    OD_FIXED(OD_UNSIGNED32, 4, 0x1000, 0, 0, INT64_C(0xFFFF0192), "Device type",
             "CiA 402 device with two drives, see 67FF and 6FFF"),
    OD_FIXED_TEXT(0x1008, 0, "trackservo", "Manufacturer device name", "Two-axis tracker servo"),
    OD_TEXT(0x1009, 0, OD_CONST, 0, communication_objects, hardware_version, "", "Manufacturer hardware version",
            "Product and board; host: the simulator"),
    OD_FIXED_TEXT(0x100A, 0, TRACKSERVO_VERSION, "Manufacturer software version",
                  "For information; tools compare 0x3030:2 instead"),
    CANOPEN_IDENTITY_ROWS(0, PRODUCT_CODE, REVISION),
    CANOPEN_RPDO_ROWS(0, "1", 0, 255, 0),
    CANOPEN_RPDO_ROWS(1, "2", 0, 255, 0),
    CANOPEN_RPDO_ROWS(2, "3", 0, 255, 0),
    CANOPEN_RPDO_ROWS(3, "4", 0, 255, 0),
    CANOPEN_MAPPING_ROWS(0x1600, rpdo_mapping[0], "RPDO1", 2, MAP(0x6040, 0, 16), MAP(0x6060, 0, 8), 0, 0, 0, 0, 0, 0),
    CANOPEN_MAPPING_ROWS(0x1601, rpdo_mapping[1], "RPDO2", 2, MAP(0x6840, 0, 16), MAP(0x6860, 0, 8), 0, 0, 0, 0, 0, 0),
    CANOPEN_MAPPING_ROWS(0x1602, rpdo_mapping[2], "RPDO3", 2, MAP(0x60FF, 0, 32), MAP(0x68FF, 0, 32), 0, 0, 0, 0, 0, 0),
    CANOPEN_MAPPING_ROWS(0x1603, rpdo_mapping[3], "RPDO4", 2, MAP(0x607A, 0, 32), MAP(0x687A, 0, 32), 0, 0, 0, 0, 0, 0),
    CANOPEN_TPDO_ROWS(0, "1", 0, 255, INHIBIT_100US, STATE_EVENT_MS),
    CANOPEN_TPDO_ROWS(1, "2", 0, 255, INHIBIT_100US, STATE_EVENT_MS),
    CANOPEN_TPDO_ROWS(2, "3", 0, 255, INHIBIT_100US, VALUE_EVENT_MS),
    CANOPEN_TPDO_ROWS(3, "4", 0, 255, INHIBIT_100US, VALUE_EVENT_MS),
    CANOPEN_FURTHER_TPDO_ROWS(4, "5", 255, INHIBIT_100US, 0),
    CANOPEN_FURTHER_TPDO_ROWS(5, "6", 255, INHIBIT_100US, 0),
    CANOPEN_FURTHER_TPDO_ROWS(6, "7", 255, INHIBIT_100US, 0),
    CANOPEN_FURTHER_TPDO_ROWS(7, "8", 255, INHIBIT_100US, 0),
    CANOPEN_MAPPING_ROWS(0x1A00, tpdo_mapping[0], "TPDO1", 4, MAP(0x6041, 0, 16), MAP(0x6061, 0, 8), MAP(0x603F, 0, 16),
                         MAP(0x6077, 0, 16), 0, 0, 0, 0),
    CANOPEN_MAPPING_ROWS(0x1A01, tpdo_mapping[1], "TPDO2", 4, MAP(0x6841, 0, 16), MAP(0x6861, 0, 8), MAP(0x683F, 0, 16),
                         MAP(0x6877, 0, 16), 0, 0, 0, 0),
    CANOPEN_MAPPING_ROWS(0x1A02, tpdo_mapping[2], "TPDO3", 2, MAP(0x606C, 0, 32), MAP(0x686C, 0, 32), 0, 0, 0, 0, 0, 0),
    CANOPEN_MAPPING_ROWS(0x1A03, tpdo_mapping[3], "TPDO4", 2, MAP(0x6064, 0, 32), MAP(0x6864, 0, 32), 0, 0, 0, 0, 0, 0),
    CANOPEN_MAPPING_ROWS(0x1A04, tpdo_mapping[4], "TPDO5", 0, 0, 0, 0, 0, 0, 0, 0, 0),
    CANOPEN_MAPPING_ROWS(0x1A05, tpdo_mapping[5], "TPDO6", 0, 0, 0, 0, 0, 0, 0, 0, 0),
    CANOPEN_MAPPING_ROWS(0x1A06, tpdo_mapping[6], "TPDO7", 0, 0, 0, 0, 0, 0, 0, 0, 0),
    CANOPEN_MAPPING_ROWS(0x1A07, tpdo_mapping[7], "TPDO8", 0, 0, 0, 0, 0, 0, 0, 0, 0),
};

const od_table device_table = {kEntries, sizeof kEntries / sizeof kEntries[0]};
