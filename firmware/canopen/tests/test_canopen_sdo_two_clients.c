/* SPDX-License-Identifier: Apache-2.0 */
/* Two clients on one SDO channel, like python-canopen: each takes the first answer after its request, whoever sent the
 * request, and compares the object only in the answer to an upload. Whatever the order of their requests, no client
 * reads a wrong value and no value is written that no client sent.
 *
 * Each waits up to 90 ms between an answer and its next request, usually a few. */
#include <stdio.h>

#include "canopen/bench.h"
#include "support/random.h"

enum { CLIENTS = 2, REQUEST = 0x600 + BENCH_NODE, ANSWER = 0x580 + BENCH_NODE, PATIENCE_MS = 300, PENDING = 64 };

typedef enum { UPLOAD, EXPEDITED_DOWNLOAD, SEGMENTED_DOWNLOAD } kind;

typedef struct {
  uint16_t index;
  uint8_t sub;
  const char *bytes; /* NULL: the client's own number */
  uint32_t length;
} target;

static const target constants[] = {{0x1008, 0, "test device", 11},
                                   {0x100A, 0, "0.0.1", 5},
                                   {0x2F00, 10, "hello world", 11},
                                   {0x2F00, 8, "\xEF\xCD\xAB\x89\x67\x45\x23\x01", 8},
                                   {0x2F00, 12, "\x34\x12", 2}};
static const target own[CLIENTS] = {{0x2F00, 7, NULL, 4}, {0x1006, 0, NULL, 4}};
enum { CONSTANTS = sizeof constants / sizeof constants[0] };

typedef struct {
  kind does;
  target what;
  bool busy;
  bool initiated; /* the answer to the initiate request has come */
  bool last;      /* the last segment has been sent */
  bool answered;
  uint8_t answer[8];
  uint8_t toggle;
  uint32_t wait_ms; /* between requests, or for an answer */
  uint8_t bytes[64];
  uint32_t got;
  uint32_t value; /* being written */
  uint32_t may_be[PENDING];
  uint32_t may_be_count;
  uint32_t right, aborted, wrong;
} client;

static client clients[CLIENTS];
static random_source source;

void setUp(void) {
  bench_start();
  memset(clients, 0, sizeof clients);
  source.state = 1;
  for (uint32_t n = 0; n < CLIENTS; n++) {
    clients[n].may_be[0] = bench_get(own[n].index, own[n].sub);
    clients[n].may_be_count = 1;
  }
}

void tearDown(void) {}

static uint32_t random_below(uint32_t end) { return (uint32_t)(random_bits(&source) % end); }

static void think(client *self) { self->wait_ms = random_below(20) == 0 ? random_below(90) : random_below(5); }

static void send(client *self, const uint8_t request[8]) {
  bench_give(REQUEST, 8, request);
  self->answered = false;
  self->wait_ms = PATIENCE_MS;
}

static void finish(client *self, bool right) {
  self->busy = false;
  self->right += right ? 1 : 0;
  self->aborted += right ? 0 : 1;
  think(self);
}

static void give_up(client *self, bool say_so) {
  static const uint8_t nameless[8] = {0x80};
  if (say_so) {
    bench_give(REQUEST, 8, nameless);
  }
  finish(self, false);
}

static void begin(client *self, uint32_t n) {
  static const uint8_t commands[] = {[UPLOAD] = 0x40, [EXPEDITED_DOWNLOAD] = 0x23, [SEGMENTED_DOWNLOAD] = 0x21};
  const uint32_t choice = random_below(CONSTANTS + 4);
  self->does = choice < CONSTANTS + 1 ? UPLOAD : choice < CONSTANTS + 2 ? EXPEDITED_DOWNLOAD : SEGMENTED_DOWNLOAD;
  self->what = choice < CONSTANTS ? constants[choice] : own[n];
  self->busy = true;
  self->initiated = self->last = false;
  self->toggle = 0;
  self->got = 0;
  const uint8_t command = commands[self->does];
  uint8_t request[8] = {command, (uint8_t)self->what.index, (uint8_t)(self->what.index >> 8), self->what.sub, 4};
  if (self->does != UPLOAD) {
    self->value = random_below(1000000);
    self->may_be[self->may_be_count % PENDING] = self->value;
    self->may_be_count++;
  }
  if (self->does == EXPEDITED_DOWNLOAD) {
    memcpy(&request[4], &self->value, 4);
  }
  send(self, request);
}

static bool is_right(const client *self) {
  if (self->what.bytes != NULL) {
    return self->got == self->what.length && memcmp(self->bytes, self->what.bytes, self->got) == 0;
  }
  bool found = false;
  for (uint32_t i = 0; i < self->may_be_count && i < PENDING; i++) {
    found = found || memcmp(self->bytes, &self->may_be[i], 4) == 0;
  }
  return found && self->got == 4;
}

static void judge(client *self) {
  self->wrong += is_right(self) ? 0 : 1;
  finish(self, true);
}

static void take(client *self, const uint8_t *from, uint32_t length) {
  memcpy(&self->bytes[self->got], from, length);
  self->got += length;
}

static void go_on_uploading(client *self) {
  const uint8_t *answer = self->answer;
  if (!self->initiated) {
    if (answer[0] >> 5 != 2 || (answer[1] | answer[2] << 8) != self->what.index || answer[3] != self->what.sub) {
      give_up(self, false);
      return;
    }
    if ((answer[0] & 2) != 0) {
      take(self, &answer[4], 4u - (answer[0] >> 2 & 3u));
      judge(self);
      return;
    }
    self->initiated = true;
  } else if (answer[0] >> 5 != 0 || (answer[0] & 0x10) != self->toggle) {
    give_up(self, true);
    return;
  } else {
    take(self, &answer[1], 7u - (answer[0] >> 1 & 7u));
    self->toggle ^= 0x10;
    if ((answer[0] & 1) != 0 || self->got > sizeof self->bytes - 7) {
      judge(self);
      return;
    }
  }
  const uint8_t request[8] = {(uint8_t)(0x60 | self->toggle)};
  send(self, request);
}

static void confirmed(client *self) {
  self->may_be[0] = self->value;
  self->may_be_count = 1;
  finish(self, true);
}

static void go_on_downloading(client *self) {
  const uint8_t specifier = self->answer[0] >> 5;
  if (specifier != (self->last ? 1 : 3)) {
    give_up(self, true);
  } else if (self->last || self->does == EXPEDITED_DOWNLOAD) {
    confirmed(self);
  } else {
    uint8_t request[8] = {3 << 1 | 1};
    memcpy(&request[1], &self->value, 4);
    self->last = true;
    send(self, request);
  }
}

static void step(client *self, uint32_t n) {
  if (self->wait_ms > 0) {
    self->wait_ms--;
  } else if (!self->busy) {
    begin(self, n);
  } else if (!self->answered) {
    give_up(self, true);
  } else if (self->answer[0] == 0x80) {
    finish(self, false);
  } else if (self->does == UPLOAD) {
    go_on_uploading(self);
  } else {
    go_on_downloading(self);
  }
}

static void hear(client *self, const can_frame *frame) {
  if (self->busy && !self->answered) {
    memcpy(self->answer, frame->data, 8);
    self->answered = true;
    think(self);
  }
}

static void pass_ms(void) {
  const uint32_t first = random_below(CLIENTS);
  bench.sent = 0;
  for (uint32_t i = 0; i < CLIENTS; i++) {
    const uint32_t n = (first + i) % CLIENTS;
    step(&clients[n], n);
  }
  bench_wait_ms(1);
  for (uint32_t i = 0; i < bench.sent; i++) {
    for (uint32_t n = 0; n < CLIENTS && bench.log[i].id == ANSWER; n++) {
      hear(&clients[n], &bench.log[i]);
    }
  }
}

static void test_two_clients_on_one_channel_get_no_wrong_value(void) {
  const uint32_t duration_ms = (uint32_t)random_cases(2000000);
  for (uint32_t ms = 0; ms < duration_ms; ms++) {
    pass_ms();
  }
  for (uint32_t n = 0; n < CLIENTS; n++) {
    printf("client %u: %u right, %u aborted, %u wrong\n", (unsigned)n, (unsigned)(clients[n].right - clients[n].wrong),
           (unsigned)clients[n].aborted, (unsigned)clients[n].wrong);
    TEST_ASSERT_EQUAL(0, clients[n].wrong);
    TEST_ASSERT_TRUE(clients[n].right > clients[n].aborted / 4 && clients[n].aborted > 0);
  }
}

int main(void) {
  UNITY_BEGIN();
  RUN_TEST(test_two_clients_on_one_channel_get_no_wrong_value);
  return UNITY_END();
}
