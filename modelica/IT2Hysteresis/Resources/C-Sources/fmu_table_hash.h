/* Generated from variables.toml by codegen.py. */
#define FMU_TABLE_HASH_PLANT 0xdcb71081a2c0a4d9u
#define FMU_TABLE_HASH_INVERSE 0x1cc1279dfd572e08u
