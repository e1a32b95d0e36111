/* Generated from variables.toml by codegen.py. */
#ifndef IT2HYS_FMU_PLACES_H
#define IT2HYS_FMU_PLACES_H
#define IN_REFERENCE 0
#define IN_FORCE 1
#define IN_TEMPERATURE 2
#define OUT_VOLTAGE 0
#define OUT_SATURATED 0
#define IN_VOLTAGE 0
#define OUT_DISPLACEMENT 0
#define OUT_MEASURED 1
#define OUT_OUT_OF_RANGE 0
#define FMU_TABLE_ROWS 200
#define FMU_PLANT_INPUT_START { 0.0, 0.0, 293.15 }
#define FMU_INVERSE_INPUT_START { 0.0, 0.0, 293.15 }
#endif
