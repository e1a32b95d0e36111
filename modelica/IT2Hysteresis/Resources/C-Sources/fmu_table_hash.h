/* Generated from variables.toml by codegen.py. */
#define FMU_TABLE_HASH_PLANT 0x916d20a863ad8426u
#define FMU_TABLE_HASH_INVERSE 0x1cc1279dfd572e08u
