/* Generated from variables.toml by codegen.py. */
#define FMU_TABLE_HASH_PLANT 0x6f47eb75cb592cbbu
#define FMU_TABLE_HASH_INVERSE 0x34765cc746d92d9cu
