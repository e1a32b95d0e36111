/* Runs a fuzz target without libFuzzer: byte strings are mutations of a corpus by a fixed generator,
 * so that every machine runs the same ones.
 *
 *   fuzz_<target> [-n SEQUENCES] [-t SECONDS] [-s SEED] [CORPUS.hex]
 *   fuzz_<target> -x HEX                                                one string again */
#include <signal.h>
#include <time.h>

#include "fuzz.h"

enum { LONGEST = 256, CORPUS_CAPACITY = 1024 };

struct string {
    size_t size;
    uint8_t byte[LONGEST];
};

static struct string corpus[CORPUS_CAPACITY];
static size_t corpus_size;
static struct string current;
static uint64_t generator;

static uint64_t draw(uint64_t below)
{
    generator ^= generator << 13; /* xorshift64 */
    generator ^= generator >> 7;
    generator ^= generator << 17;
    return (generator >> 11) % below;
}

/* --- what is run when a sanitizer or a promise ends the program ---------------------------------- */

static void print_current(void)
{
    fputs("the byte string: ", stderr);
    for (size_t i = 0; i < current.size; i++)
        fprintf(stderr, "%02x", current.byte[i]);
    fputc('\n', stderr);
}

static void on_signal(int number)
{
    print_current();
    signal(number, SIG_DFL);
    raise(number);
}

void __asan_on_error(void); /* called by AddressSanitizer where it is linked */
void __asan_on_error(void)
{
    print_current();
}

/* --- corpus and mutations ------------------------------------------------------------------------ */

static void read_hex(const char *text, struct string *string)
{
    unsigned byte;

    string->size = 0;
    while (string->size < LONGEST && sscanf(text, "%2x", &byte) == 1) {
        string->byte[string->size++] = (uint8_t)byte;
        text += 2;
    }
}

static void read_corpus(const char *path)
{
    char line[2 * LONGEST + 2];
    FILE *file = fopen(path, "r");

    if (!file) {
        fprintf(stderr, "%s: cannot be read\n", path);
        exit(2);
    }
    while (corpus_size < CORPUS_CAPACITY && fgets(line, sizeof line, file))
        read_hex(line, &corpus[corpus_size++]);
    fclose(file);
}

static void insert_random(struct string *s)
{
    const size_t count = 1 + (size_t)draw(8);
    const size_t at = (size_t)draw(s->size + 1);

    if (s->size + count > LONGEST)
        return;
    memmove(s->byte + at + count, s->byte + at, s->size - at);
    for (size_t i = 0; i < count; i++)
        s->byte[at + i] = (uint8_t)draw(256);
    s->size += count;
}

static void remove_some(struct string *s)
{
    const size_t at = (size_t)draw(s->size + 1);
    const size_t count = (size_t)draw(s->size - at + 1);

    memmove(s->byte + at, s->byte + at + count, s->size - at - count);
    s->size -= count;
}

/* The end of another string of the corpus in place of this one's. */
static void splice(struct string *s)
{
    const struct string *other = &corpus[draw(corpus_size)];
    const size_t keep = (size_t)draw(s->size + 1), from = (size_t)draw(other->size + 1);
    size_t count = other->size - from;

    if (keep + count > LONGEST)
        count = LONGEST - keep;
    memcpy(s->byte + keep, other->byte + from, count);
    s->size = keep + count;
}

static void mutate(struct string *s)
{
    const unsigned kind = (unsigned)draw(5);

    if (s->size == 0 || kind == 0)
        insert_random(s);
    else if (kind == 1)
        remove_some(s);
    else if (kind == 2 && corpus_size)
        splice(s);
    else if (kind == 3)
        s->byte[draw(s->size)] ^= (uint8_t)(1u << draw(8));
    else
        s->byte[draw(s->size)] = (uint8_t)draw(256);
}

/* One in eight strings is random throughout. */
static void make_string(struct string *s)
{
    s->size = 0;
    if (corpus_size && draw(8)) {
        *s = corpus[draw(corpus_size)];
        for (uint64_t n = 1 + draw(6); n > 0; n--)
            mutate(s);
        return;
    }
    s->size = (size_t)draw(64);
    for (size_t i = 0; i < s->size; i++)
        s->byte[i] = (uint8_t)draw(256);
}

/* --- the run ------------------------------------------------------------------------------------- */

static void run(const char *name, unsigned long sequences, double seconds, unsigned long seed)
{
    const clock_t start = clock();
    unsigned long done = 0;

    generator = 0x9e3779b97f4a7c15u ^ seed * 0xbf58476d1ce4e5b9u;
    for (size_t i = 0; i < corpus_size; i++) {
        current = corpus[i];
        LLVMFuzzerTestOneInput(current.byte, current.size);
    }
    while (done < sequences && (seconds <= 0.0 || (double)(clock() - start) / CLOCKS_PER_SEC < seconds)) {
        make_string(&current);
        LLVMFuzzerTestOneInput(current.byte, current.size);
        done++;
    }
    const double spent = (double)(clock() - start) / CLOCKS_PER_SEC;
    printf("%s: %lu sequences, mutated from a corpus of %lu, seed %lu, in %.1f s of CPU: no finding\n", name,
           done, (unsigned long)corpus_size, seed, spent);
}

int main(int count, char **argument)
{
    unsigned long sequences = 100000, seed = 1;
    double seconds = 0.0;

    signal(SIGABRT, on_signal);
    signal(SIGSEGV, on_signal);
    signal(SIGFPE, on_signal);
    for (int i = 1; i < count; i++) {
        const char *option = argument[i];
        if (option[0] != '-') {
            read_corpus(option);
            continue;
        }
        const char *value = ++i < count ? argument[i] : "0";
        if (option[1] == 'x') {
            read_hex(value, &current);
            return LLVMFuzzerTestOneInput(current.byte, current.size);
        }
        if (option[1] == 'n')
            sequences = strtoul(value, NULL, 10);
        else if (option[1] == 's')
            seed = strtoul(value, NULL, 10);
        else
            seconds = strtod(value, NULL);
    }
    run(argument[0], sequences, seconds, seed);
    return 0;
}
