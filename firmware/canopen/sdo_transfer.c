/* SPDX-License-Identifier: Apache-2.0 */
#include "canopen/sdo_transfer.h"

#include <string.h>

static bool is_stream(const sdo_transfer *transfer) { return transfer->object.entry->type == OD_DOMAIN; }

static od_abort begin_stream(const od_object *object, bool writing, uint32_t *size) {
  const od_hooks *hooks = object->part->hooks;
  if (hooks == NULL || hooks->stream_begin == NULL ||
      (writing ? hooks->stream_write == NULL : hooks->stream_read == NULL)) {
    return OD_UNSUPPORTED;
  }
  return hooks->stream_begin(object->part->owner, object, writing, size);
}

static od_abort end_stream(const sdo_transfer *transfer, bool complete) {
  const od_hooks *hooks = transfer->object.part->hooks;
  if (hooks->stream_end == NULL) {
    return OD_OK;
  }
  const uint32_t total = transfer->writing ? transfer->position : transfer->size;
  return hooks->stream_end(transfer->object.part->owner, &transfer->object, transfer->writing, complete, total);
}

od_abort sdo_transfer_open_read(sdo_transfer *transfer, const od_object *object) {
  if (object->entry->access == OD_WO) {
    return OD_WRITE_ONLY;
  }
  od_abort answer;
  if (object->entry->type == OD_DOMAIN) {
    transfer->size = 0;
    answer = begin_stream(object, false, &transfer->size);
  } else {
    uint16_t length = 0;
    answer = od_read(object, transfer->buffer, SDO_BUFFER_BYTES, &length);
    transfer->size = length;
  }
  transfer->object = *object;
  transfer->writing = false;
  transfer->position = 0;
  transfer->open = answer == OD_OK;
  return answer;
}

od_abort sdo_transfer_read(sdo_transfer *transfer, uint32_t offset, uint8_t *bytes, uint32_t length) {
  if (!transfer->open || offset > transfer->size || length > transfer->size - offset) {
    return OD_GENERAL;
  }
  if (is_stream(transfer)) {
    const od_part *part = transfer->object.part;
    return part->hooks->stream_read(part->owner, &transfer->object, offset, bytes, length);
  }
  memcpy(bytes, &transfer->buffer[offset], length);
  return OD_OK;
}

static od_abort check_announced_size(const od_entry *entry, uint32_t size) {
  if (size == OD_SIZE_UNKNOWN) {
    return OD_OK;
  }
  if (size > entry->bytes || size > SDO_BUFFER_BYTES) {
    return OD_TOO_LONG;
  }
  return entry->type != OD_VISIBLE_STRING && size < entry->bytes ? OD_TOO_SHORT : OD_OK;
}

od_abort sdo_transfer_open_write(sdo_transfer *transfer, const od_object *object, uint32_t announced_size) {
  if (object->entry->access == OD_CONST || object->entry->access == OD_RO) {
    return OD_READ_ONLY;
  }
  uint32_t size = announced_size;
  const od_abort answer = object->entry->type == OD_DOMAIN ? begin_stream(object, true, &size)
                                                           : check_announced_size(object->entry, announced_size);
  transfer->object = *object;
  transfer->writing = true;
  transfer->size = announced_size;
  transfer->position = 0;
  transfer->open = answer == OD_OK;
  return answer;
}

od_abort sdo_transfer_append(sdo_transfer *transfer, const uint8_t *bytes, uint32_t length) {
  if (!transfer->open || !transfer->writing) {
    return OD_GENERAL;
  }
  if (length == 0) {
    return OD_OK;
  }
  const uint32_t room = is_stream(transfer) ? OD_SIZE_UNKNOWN - 1 : SDO_BUFFER_BYTES;
  const uint32_t limit = transfer->size < room ? transfer->size : room;
  if (length > limit - transfer->position) {
    return OD_TOO_LONG;
  }
  if (is_stream(transfer)) {
    const od_part *part = transfer->object.part;
    const od_abort answer =
        part->hooks->stream_write(part->owner, &transfer->object, transfer->position, bytes, length);
    if (answer != OD_OK) {
      return answer;
    }
  } else {
    memcpy(&transfer->buffer[transfer->position], bytes, length);
  }
  transfer->position += length;
  return OD_OK;
}

od_abort sdo_transfer_commit(sdo_transfer *transfer) {
  if (!transfer->open || !transfer->writing) {
    return OD_GENERAL;
  }
  if (transfer->size != OD_SIZE_UNKNOWN && transfer->position != transfer->size) {
    sdo_transfer_close(transfer);
    return OD_TOO_SHORT;
  }
  const od_abort answer = is_stream(transfer)
                              ? end_stream(transfer, true)
                              : od_write(&transfer->object, transfer->buffer, (uint16_t)transfer->position);
  if (answer != OD_PENDING) {
    transfer->open = false;
  }
  return answer;
}

void sdo_transfer_close(sdo_transfer *transfer) {
  if (!transfer->open) {
    return;
  }
  transfer->open = false;
  if (is_stream(transfer)) {
    (void)end_stream(transfer, !transfer->writing);
  }
}
