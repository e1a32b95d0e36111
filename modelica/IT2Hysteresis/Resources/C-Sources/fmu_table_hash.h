/* Generated from variables.toml by codegen.py. */
#define FMU_TABLE_HASH_PLANT 0x96c67765da31759fu
#define FMU_TABLE_HASH_INVERSE 0xd0022e4894abd47du
