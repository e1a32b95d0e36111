/* Chain, inverse, tangents, check and sensitivity with a twelfth stage; what fails first is printed. */
#include "chain_sensitivity.h"
#include "effect_sets.h"
#define MUST(condition) \
    do { \
        if (!(condition)) \
            return printf("line %d: " #condition "\n", __LINE__), 1; \
    } while (0)

enum { TICKS = 60 };

static void predict(const struct chain_parameters *p, const double *u, double *y)
{
    static const double zero[TICKS];
    double x[TICKS], core[TICKS];
    chain_predict(p, &(struct chain_record){ u, zero, zero, 0, TICKS }, y, x, core);
}

int main(void)
{
    static double u[TICKS], y[TICKS], up[TICKS], down[TICKS], zero[TICKS], by[TICKS * 25];
    const struct chain_surroundings around = { 0.0, 293.15, 0.0 }, none = { 0.0, 0.0, 0.0 };
    const size_t place = offsetof(struct chain_parameters, tilt.gain);
    struct chain_parameters p;
    struct chain chain;
    struct chain_state plant, inverse, d = { .core = { 0.3 }, .tilt = { -0.7 } };
    char message[512];
    uint64_t seed = 3;
    unsigned limits;

    plain(&p);
    chain_prepare(&chain, &p);
    MUST(chain.effects == 0 && chain.walked == sizeof(double) && chain.retraced == sizeof(double));
    add_effects(&seed, &p, CHAIN_LAG | CHAIN_PLAY | CHAIN_CREEP | CHAIN_RESONANCE);
    p.tilt.gain = -2.0;
    MUST(!chain_check(&p, message, sizeof message) && strstr(message, "tilt.gain is -2"));
    p.tilt.gain = 0.4;
    MUST(chain_check(&p, message, sizeof message));
    chain_prepare(&chain, &p);
    MUST(chain.effects & CHAIN_TILT);
    chain_reset(&chain, &plant, &p);
    chain_reset(&chain, &inverse, &p);
    for (int k = 0; k < TICKS; k++) {
        const double aim = 5.0 + 0.02 * k * sin(0.1 * k);
        u[k] = chain_inverse(&chain, &inverse, aim, &around, &limits);
        MUST(limits == 0 && fabs(chain_step(&chain, &plant, u[k], &around) - aim) < 1e-9);
    }
    d.reached = (struct chain_reached){ .core = d.core, .tilt = d.tilt };
    for (int back = 0; back < 2; back++) {
        const struct chain_point t = back ? chain_inverse_tangent(&chain, &inverse, 5.0, &around, d, 0.5, &none)
                                          : chain_step_tangent(&chain, &inverse, 40.0, &around, d, 0.5, &none);
        double end[2];
        for (int i = 0; i < 2; i++) {
            const double h = i ? 1e-6 : -1e-6;
            struct chain_state s = inverse;
            s.core.y += 0.3 * h, s.reached.core.y += 0.3 * h;
            s.tilt.x -= 0.7 * h, s.reached.tilt.x -= 0.7 * h;
            end[i] = back ? chain_inverse(&chain, &s, 5.0 + 0.5 * h, &around, &limits)
                          : chain_step(&chain, &s, 40.0 + 0.5 * h, &around);
        }
        const double slope = (end[1] - end[0]) / 2e-6;
        MUST(fabs(t.output - slope) < 1e-5 * fmax(1.0, fabs(slope)) && slope != 0.0);
    }
    MUST(chain_sensitivity(&p, &(struct chain_record){ u, zero, zero, 0, TICKS }, true, &place, 1, y, by) ==
         TICKS);
    p.tilt.gain += 1e-5;
    predict(&p, u, up);
    p.tilt.gain -= 2e-5;
    predict(&p, u, down);
    double largest = 0.0;
    for (int k = 0; k < TICKS; k++) {
        const double slope = (up[k] - down[k]) / 2e-5;
        largest = fmax(largest, fabs(slope));
        MUST(fabs(by[19 * k + 18] - slope) < 1e-7);
    }
    MUST(largest > 1e-3);
    return 0;
}
