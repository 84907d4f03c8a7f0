/* SPDX-License-Identifier: Apache-2.0 */
#include "node/objects/bus_objects.h"

void bus_objects_start(bus_objects *bus, const bus_settings *defaults, bool recovering, const hal_flash *flash,
                       const bus_joiner *joiner) {
  *bus = (bus_objects){.joiner = *joiner};
  bus_settings_log_open(&bus->log, flash, defaults);
  bus->stored = bus->log.newest;
  bus->in_force = recovering ? *defaults : bus->stored;
}

void bus_objects_join(bus_objects *bus, uint16_t kbit_s) {
  bus->in_force.kbit_s = kbit_s;
  bus->join_failed = bus->joiner.join != NULL && !bus->joiner.join(bus->joiner.context, kbit_s);
}

lss_store_progress bus_objects_store(bus_objects *bus, const bus_settings *settings) {
  if (!bus->saving) {
    bus->saving = bus_settings_log_begin(&bus->log, settings);
  }
  switch (bus_settings_log_take_result(&bus->log)) {
    case BUS_SETTINGS_SAVED:
      bus->saving = false;
      bus->stored = *settings;
      return LSS_STORE_DONE;
    case BUS_SETTINGS_FAILED:
      bus->saving = false;
      return LSS_STORE_REFUSED;
    default:
      return LSS_STORE_PENDING;
  }
}
