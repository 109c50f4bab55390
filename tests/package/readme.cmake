# cmake -D README=... -D EXAMPLE=... -P readme.cmake: the program in the README is the example, character by character.
file(READ ${README} readme)
file(READ ${EXAMPLE} example)
string(FIND "${readme}" "${example}" at)
if(at EQUAL -1)
    message(FATAL_ERROR "the program in ${README} is not ${EXAMPLE}")
endif()
