/* 2^(j/64), j = 0..63, for exponential.h: the bits of the nearest double less j * 2^46, so that adding
 * a multiple of 2^46 sets the exponent, and what rounding left off, relative to it. Two tables: an index
 * into one of pairs costs two instructions more. */
/* clang-format off */
static const uint64_t EXP_BITS[EXP_STEPS] = {
    0x3ff0000000000000u, 0x3fefec9a3e778061u, 0x3fefd9b0d3158574u, 0x3fefc74518759bc8u,
    0x3fefb5586cf9890fu, 0x3fefa3ec32d3d1a2u, 0x3fef9301d0125b51u, 0x3fef829aaea92de0u,
    0x3fef72b83c7d517bu, 0x3fef635beb6fcb75u, 0x3fef54873168b9aau, 0x3fef463b88628cd6u,
    0x3fef387a6e756238u, 0x3fef2b4565e27cddu, 0x3fef1e9df51fdee1u, 0x3fef1285a6e4030bu,
    0x3fef06fe0a31b715u, 0x3feefc08b26416ffu, 0x3feef1a7373aa9cbu, 0x3feee7db34e59ff7u,
    0x3feedea64c123422u, 0x3feed60a21f72e2au, 0x3feece086061892du, 0x3feec6a2b5c13cd0u,
    0x3feebfdad5362a27u, 0x3feeb9b2769d2ca7u, 0x3feeb42b569d4f82u, 0x3feeaf4736b527dau,
    0x3feeab07dd485429u, 0x3feea76f15ad2148u, 0x3feea47eb03a5585u, 0x3feea23882552225u,
    0x3feea09e667f3bcdu, 0x3fee9fb23c651a2fu, 0x3fee9f75e8ec5f74u, 0x3fee9feb564267c9u,
    0x3feea11473eb0187u, 0x3feea2f336cf4e62u, 0x3feea589994cce13u, 0x3feea8d99b4492edu,
    0x3feeace5422aa0dbu, 0x3feeb1ae99157736u, 0x3feeb737b0cdc5e5u, 0x3feebd829fde4e50u,
    0x3feec49182a3f090u, 0x3feecc667b5de565u, 0x3feed503b23e255du, 0x3feede6b5579fdbfu,
    0x3feee89f995ad3adu, 0x3feef3a2b84f15fbu, 0x3feeff76f2fb5e47u, 0x3fef0c1e904bc1d2u,
    0x3fef199bdd85529cu, 0x3fef27f12e57d14bu, 0x3fef3720dcef9069u, 0x3fef472d4a07897cu,
    0x3fef5818dcfba487u, 0x3fef69e603db3285u, 0x3fef7c97337b9b5fu, 0x3fef902ee78b3ff6u,
    0x3fefa4afa2a490dau, 0x3fefba1bee615a27u, 0x3fefd0765b6e4540u, 0x3fefe7c1819e90d8u,
};

static const double EXP_TAIL[EXP_STEPS] = {
    0x0.0p+0, -0x1.160139cd8dc5dp-56, 0x1.cd2523567f613p-55, 0x1.0f74e61e6c861p-57,
    0x1.79aa65d837b6dp-54, 0x1.ebe3d702f9cd1p-60, -0x1.556522a2fbd0ep-54, -0x1.1c923b9d5f416p-54,
    -0x1.01b15eaa59348p-55, 0x1.b898c3f1353bfp-55, 0x1.aecf73e3a2f60p-54, 0x1.a6f4144a6c38dp-55,
    0x1.68efde3a8a894p-54, 0x1.0472b981fe7f2p-55, 0x1.2f7e16d09ab31p-55, 0x1.b3782720c0ab4p-55,
    0x1.34d754db0abb6p-55, 0x1.fdd395dd3f84ap-55, -0x1.24aedcc4b5068p-54, -0x1.1d1e83e9436d2p-56,
    0x1.59f48a72a4c6dp-55, -0x1.8a78f4817895bp-58, 0x1.363ed60c2ac11p-59, 0x1.ecce1daa10379p-57,
    0x1.690cebb7aafb0p-56, -0x1.f94340071a38ep-55, -0x1.8dec6bd0f385fp-56, 0x1.3350518fdd78ep-54,
    0x1.063e1e21c5409p-54, 0x1.432e62b64c035p-54, -0x1.c33c53bef4da8p-55, -0x1.3cedd78565858p-54,
    -0x1.3b3efbf5e2228p-54, -0x1.367efb86da9eep-57, -0x1.81f647e5a3ecfp-56, -0x1.619321e55e68ap-55,
    -0x1.b32dcb94da51dp-56, 0x1.5ebe1abd66c55p-57, -0x1.369b6f13b3734p-54, -0x1.4d450d872576ep-54,
    0x1.db72fc1f0eab4p-55, 0x1.bf68359f35f44p-56, -0x1.da9b88b6c1e29p-58, -0x1.2434322f4f9aap-54,
    0x1.1affc2b91ce27p-56, -0x1.7c50422622263p-55, -0x1.1bbd1d3bcbb15p-54, 0x1.469846e735ab3p-55,
    0x1.c1a7792cb3387p-55, -0x1.5c3d956dcaebap-58, -0x1.8d6f438ad9334p-57, 0x1.4ffd70a5fddcdp-56,
    0x1.36eae30af0cb3p-56, 0x1.4e08fd10959acp-55, 0x1.76b2c6c921968p-57, -0x1.fad5d3ffffa6fp-55,
    0x1.4a385a63d07a7p-56, 0x1.e5a50d5c192acp-55, -0x1.2d52107b43e1fp-55, 0x1.4b604603a88d3p-56,
    -0x1.ff7128fd391f0p-55, 0x1.ec3bc41aa2008p-55, 0x1.a64a931d185eep-55, 0x1.7893b4d91cd9dp-56,
};
/* clang-format on */
