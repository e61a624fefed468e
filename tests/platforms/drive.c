/* Drives a packed library as an importer does, and prints impulses and hashes of states, which are the same on every platform.
 *
 *     drive LIBRARY GUID RESOURCES STEP STEPS CYCLES THREADS_REFERENCE IMPULSE_REFERENCE
 *
 * The run is made in each of four floating-point environments on two threads, with a state saved, serialised and gone back to
 * in its middle; then the library is loaded, run for a step and freed again, CYCLES times. The memory of the process after a
 * quarter of the cycles and after all of them is printed, in the end. */
#include <fenv.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#ifdef _WIN32
#include <windows.h>
/* After windows.h, which it needs. */
#include <psapi.h>
#define open_library(path) ((void *)LoadLibraryA(path))
#define symbol(library, name) ((void *)GetProcAddress((HMODULE)(library), name))
#define close_library(library) (FreeLibrary((HMODULE)(library)) ? 0 : 1)
#define last_error() "LoadLibrary failed"
#else
#include <dlfcn.h>
#define open_library(path) dlopen(path, RTLD_NOW | RTLD_LOCAL)
#define symbol(library, name) dlsym(library, name)
#define close_library(library) dlclose(library)
#define last_error() dlerror()
#endif

enum { OK = 0, CO_SIMULATION = 1, MOST_STEPS = 1000 };

struct callbacks {
    void (*logger)(void *, const char *, int, const char *, const char *, ...);
    void *(*allocate)(size_t, size_t);
    void (*release)(void *);
    void (*finished)(void *, int);
    void *environment;
};

static void *(*instantiate)(const char *, int, const char *, const char *, const struct callbacks *, int, int);
static int (*setup)(void *, int, double, double, int, double);
static int (*enter)(void *), (*leave)(void *);
static void (*release_instance)(void *);
static int (*step)(void *, double, double, int);
static int (*set_integer)(void *, const unsigned *, size_t, const int *);
static int (*get_real)(void *, const unsigned *, size_t, double *);
static int (*get_state)(void *, void **), (*set_state)(void *, void *), (*free_state)(void *, void **);
static int (*state_size)(void *, void *, size_t *), (*serialise)(void *, void *, char *, size_t);

static const char *guid, *resources;
static unsigned threads_reference, impulse_reference;
static double length;
static int steps, cycles;
/* Beginnings of the steps, s: products of the same rounding in every environment. */
static double times[MOST_STEPS];

static void fail(const char *call) {
    printf("failed: %s\n", call);
    exit(1);
}

static void check(const char *call, int status) {
    if (status != OK)
        fail(call);
}

static void logger(void *environment, const char *name, int status, const char *category, const char *message, ...) {
    (void)environment, (void)name, (void)category;
    if (status > OK)
        fprintf(stderr, "%s\n", message);
}

static void *find(void *library, const char *name) {
    void *found = symbol(library, name);
    if (!found)
        fail(name);
    return found;
}

static void *load(const char *path) {
    void *library = open_library(path);
    if (!library) {
        fprintf(stderr, "%s\n", last_error());
        fail(path);
    }
    *(void **)&instantiate = find(library, "fmi2Instantiate");
    *(void **)&setup = find(library, "fmi2SetupExperiment");
    *(void **)&enter = find(library, "fmi2EnterInitializationMode");
    *(void **)&leave = find(library, "fmi2ExitInitializationMode");
    *(void **)&release_instance = find(library, "fmi2FreeInstance");
    *(void **)&step = find(library, "fmi2DoStep");
    *(void **)&set_integer = find(library, "fmi2SetInteger");
    *(void **)&get_real = find(library, "fmi2GetReal");
    *(void **)&get_state = find(library, "fmi2GetFMUstate");
    *(void **)&set_state = find(library, "fmi2SetFMUstate");
    *(void **)&free_state = find(library, "fmi2FreeFMUstate");
    *(void **)&state_size = find(library, "fmi2SerializedFMUstateSize");
    *(void **)&serialise = find(library, "fmi2SerializeFMUstate");
    return library;
}

static void *begin(int threads) {
    static const struct callbacks callbacks = {logger, calloc, free, NULL, NULL};
    void *instance = instantiate("gel", CO_SIMULATION, guid, resources, &callbacks, 0, 0);
    if (!instance)
        fail("fmi2Instantiate");
    check("fmi2SetInteger", set_integer(instance, &threads_reference, 1, &threads));
    check("fmi2SetupExperiment", setup(instance, 0, 0.0, 0.0, 0, 0.0));
    check("fmi2EnterInitializationMode", enter(instance));
    check("fmi2ExitInitializationMode", leave(instance));
    return instance;
}

static void advance(void *instance, int from, int to) {
    for (int i = from; i < to; i++)
        check("fmi2DoStep", step(instance, times[i], length, 1));
}

/* FNV-1a of the serialised state. */
static uint64_t hash(void *instance) {
    void *state = NULL;
    size_t size = 0;
    uint64_t sum = 14695981039346656037u;
    check("fmi2GetFMUstate", get_state(instance, &state));
    check("fmi2SerializedFMUstateSize", state_size(instance, state, &size));
    char *bytes = malloc(size);
    if (!bytes)
        fail("malloc");
    check("fmi2SerializeFMUstate", serialise(instance, state, bytes, size));
    for (size_t i = 0; i < size; i++)
        sum = (sum ^ (unsigned char)bytes[i]) * 1099511628211u;
    free(bytes);
    check("fmi2FreeFMUstate", free_state(instance, &state));
    return sum;
}

static void run(const char *name, int environment) {
    void *state = NULL;
    double impulse = 0.0;
    if (fesetround(environment))
        fail("fesetround");
    void *instance = begin(2);
    advance(instance, 0, steps / 2);
    check("fmi2GetFMUstate", get_state(instance, &state));
    advance(instance, steps / 2, 3 * steps / 4);
    check("fmi2SetFMUstate", set_state(instance, state));
    check("fmi2FreeFMUstate", free_state(instance, &state));
    advance(instance, steps / 2, steps);
    check("fmi2GetReal", get_real(instance, &impulse_reference, 1, &impulse));
    if (fegetround() != environment)
        fail("the rounding of the importer was not put back");
    uint64_t bits;
    memcpy(&bits, &impulse, sizeof bits);
    uint64_t sum = hash(instance);
    release_instance(instance);
    fesetround(FE_TONEAREST);
    printf("%s impulse %016llx %.17g state %016llx\n", name, (unsigned long long)bits, impulse, (unsigned long long)sum);
}

/* Memory of this process, bytes: on Linux what is mapped to be written, without what an emulator needs for itself. */
static long long memory(void) {
#ifdef _WIN32
    PROCESS_MEMORY_COUNTERS counters = {0};
    if (!K32GetProcessMemoryInfo(GetCurrentProcess(), &counters, sizeof counters))
        fail("K32GetProcessMemoryInfo");
    return (long long)counters.WorkingSetSize;
#else
    long long sum = 0;
    char line[4096];
    FILE *file = fopen("/proc/self/maps", "r");
    if (!file)
        fail("/proc/self/maps");
    while (fgets(line, sizeof line, file)) {
        unsigned long long from, to;
        char rights[5];
        if (sscanf(line, "%llx-%llx %4s", &from, &to, rights) == 3 && rights[1] == 'w')
            sum += (long long)(to - from);
    }
    fclose(file);
    return sum;
#endif
}

/* Loads the library, runs a step and frees everything, many times. */
static void load_and_free(const char *path) {
    long long early = 0;
    for (int i = 0; i < cycles; i++) {
        void *library = load(path);
        void *instance = begin(2);
        advance(instance, 0, 1);
        release_instance(instance);
        if (close_library(library))
            fail("unloading");
        if (i + 1 == cycles / 4)
            early = memory();
    }
    printf("%d cycles of load, run and unload\n", cycles);
    printf("memory %lld bytes after %d cycles, %lld after all\n", early, cycles / 4, memory());
}

int main(int count, char **arguments) {
    if (count != 9)
        fail("expected LIBRARY GUID RESOURCES STEP STEPS CYCLES THREADS_REFERENCE IMPULSE_REFERENCE");
    guid = arguments[2];
    resources = arguments[3];
    length = atof(arguments[4]);
    steps = atoi(arguments[5]);
    if (steps > MOST_STEPS)
        fail("STEPS");
    for (int i = 0; i < steps; i++)
        times[i] = i * length;
    cycles = atoi(arguments[6]);
    threads_reference = (unsigned)atoi(arguments[7]);
    impulse_reference = (unsigned)atoi(arguments[8]);
    void *library = load(arguments[1]);
    run("nearest", FE_TONEAREST);
    run("upward", FE_UPWARD);
    run("downward", FE_DOWNWARD);
    run("towards zero", FE_TOWARDZERO);
    close_library(library);
    load_and_free(arguments[1]);
    return 0;
}
