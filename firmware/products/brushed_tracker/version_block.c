/* SPDX-License-Identifier: Apache-2.0 */
#include "version_block.h"

#include "products/brushed_tracker/default_schema.h"

__attribute__((section(".version_block"), used))
const volatile version_block image_version_block = {.magic = VERSION_BLOCK_MAGIC,
                                                    .format = VERSION_BLOCK_FORMAT,
                                                    .version = TRACKSERVO_VERSION,
                                                    .git = TRACKSERVO_GIT,
                                                    .schema_hash = DEFAULT_SCHEMA_HASH,
                                                    .board = TRACKSERVO_BOARD};
