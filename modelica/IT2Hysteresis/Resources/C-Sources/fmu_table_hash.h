/* Generated from variables.toml by codegen.py. */
#define FMU_TABLE_HASH_PLANT 0xd14c198a40e55f1bu
#define FMU_TABLE_HASH_INVERSE 0xc14ae232e58b247du
