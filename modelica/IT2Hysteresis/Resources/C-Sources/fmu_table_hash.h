/* Generated from variables.toml by codegen.py. */
#define FMU_TABLE_HASH_PLANT 0x506016ebacee3e63u
#define FMU_TABLE_HASH_INVERSE 0x7917ee0ef9796f81u
