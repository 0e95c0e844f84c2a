# The tests, by name. Unit tests run whole on 1, 2, 4 and 8 ranks: what they check may not depend on the ranks.
twogrid_test(NAME unit RANKS 1 2 4 8 TIMEOUT 120 LABELS unit COMMAND $<TARGET_FILE:unit_tests>)
twogrid_test(NAME verification RANKS 1 2 TIMEOUT 400 LABELS verification COMMAND $<TARGET_FILE:verification_tests>)
