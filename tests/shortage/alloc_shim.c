/* Counts the allocations of a process while it is armed, and refuses one of them, or all from one on that would add to what is
 * held then. Preloaded by tests/shortage.rs; needs glibc. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <execinfo.h>
#include <limits.h>
#include <malloc.h>
#include <stdatomic.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

extern void *__libc_malloc(size_t);
extern void *__libc_calloc(size_t, size_t);
extern void *__libc_realloc(void *, size_t);
extern void *__libc_memalign(size_t, size_t);
extern void __libc_free(void *);

enum { FRAMES = 14, OWN_FRAMES = 2, MOST_SITES = 1 << 16 };

static atomic_long live, peak, base, limit = LONG_MAX, refused;
static atomic_long ordinal = 0, fail_at = -1;
static atomic_int armed, capped;
static __thread int busy;
static FILE *profile;
static char profile_buffer[1 << 16];
static uint64_t sites[MOST_SITES];

/* Refuse the request with this number, counted from 0; with cap, from then on all that would add to what is held. */
void gel_alloc_plan(long number, int cap) { fail_at = number; capped = cap; }
void gel_alloc_arm(void) { base = (long)live; peak = (long)live; armed = 1; }
/* Bytes by which more was held since it was armed. */
long gel_alloc_disarm(void) { armed = 0; return peak - base; }
void gel_alloc_pause(int on) { busy = on; }
void gel_alloc_relieve(void) { limit = LONG_MAX; fail_at = -1; }
long gel_alloc_requests(void) { return ordinal; }
long gel_alloc_refused(void) { return refused; }

/* Writes every request to a file: a line "size site", and before a new site a line "# site frame ...". */
void gel_alloc_profile(const char *path) {
    void *warm[4];
    busy = 1;
    backtrace(warm, 4);
    profile = fopen(path, "w");
    if (profile) setvbuf(profile, profile_buffer, _IOFBF, sizeof profile_buffer);
    busy = 0;
}
void gel_alloc_end_profile(void) {
    busy = 1;
    if (profile) fclose(profile);
    profile = NULL;
    busy = 0;
}

static void note(size_t size) {
    void *frames[FRAMES];
    int n = backtrace(frames, FRAMES);
    uint64_t hash = 1469598103934665603u;
    for (int i = OWN_FRAMES; i < n; i++) hash = (hash ^ (uintptr_t)frames[i]) * 1099511628211u;
    if (!hash) hash = 1;
    for (uint64_t at = hash % MOST_SITES;; at = (at + 1) % MOST_SITES) {
        if (sites[at] == hash) break;
        if (sites[at]) continue;
        sites[at] = hash;
        fprintf(profile, "# %llx", (unsigned long long)hash);
        for (int i = OWN_FRAMES; i < n; i++) {
            Dl_info info;
            uintptr_t base = dladdr(frames[i], &info) ? (uintptr_t)info.dli_fbase : 0;
            fprintf(profile, " %#lx", (unsigned long)((uintptr_t)frames[i] - base));
        }
        fputc('\n', profile);
        break;
    }
    fprintf(profile, "%zu %llx\n", size, (unsigned long long)hash);
}

static int refuses(size_t size, size_t had) {
    if (!armed || busy) return 0;
    busy = 1;
    long own = ordinal++;
    if (profile) note(size);
    busy = 0;
    int is_due = own == fail_at;
    if (is_due && capped) limit = (long)live;
    if (is_due || live + (long)size - (long)had > limit) {
        refused++;
        errno = ENOMEM;
        return 1;
    }
    return 0;
}

static void *held(void *block) {
    if (!block) return NULL;
    long now = live += (long)malloc_usable_size(block);
    for (long seen = peak; now > seen && !atomic_compare_exchange_weak(&peak, &seen, now););
    return block;
}

static void let_go(void *block) {
    if (block) live -= (long)malloc_usable_size(block);
}

void *malloc(size_t size) { return refuses(size, 0) ? NULL : held(__libc_malloc(size)); }

void *calloc(size_t n, size_t size) {
    size_t all;
    if (__builtin_mul_overflow(n, size, &all)) return NULL;
    return refuses(all, 0) ? NULL : held(__libc_calloc(n, size));
}

void *realloc(void *block, size_t size) {
    size_t had = block ? malloc_usable_size(block) : 0;
    if (size > had && refuses(size, had)) return NULL;
    void *moved = __libc_realloc(block, size);
    if (!moved) return NULL;
    live -= (long)had;
    return held(moved);
}

void free(void *block) {
    let_go(block);
    __libc_free(block);
}

void *memalign(size_t align, size_t size) { return refuses(size, 0) ? NULL : held(__libc_memalign(align, size)); }

void *aligned_alloc(size_t align, size_t size) { return memalign(align, size); }

int posix_memalign(void **to, size_t align, size_t size) {
    void *block = memalign(align, size);
    if (!block) return ENOMEM;
    *to = block;
    return 0;
}
