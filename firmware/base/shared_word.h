/* A 32-bit word that the tick's thread and the receive interrupt share. */
#ifndef TRACKSERVO_BASE_SHARED_WORD_H
#define TRACKSERVO_BASE_SHARED_WORD_H

#include <stdint.h>

#ifdef __cplusplus
extern "C++" {
#include <atomic>
}
typedef std::atomic<uint32_t> shared_word; /* same representation as in C; C++17 has no stdatomic.h */
#else
#include <stdatomic.h>
typedef _Atomic uint32_t shared_word;
#endif

#endif
