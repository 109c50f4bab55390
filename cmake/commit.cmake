# Writes the commit that is built, where it has changed: cmake -D SOURCE=FOLDER -D OUT=HEADER -P commit.cmake
execute_process(COMMAND git describe --always --dirty --abbrev=10 --exclude=* WORKING_DIRECTORY ${SOURCE}
                OUTPUT_VARIABLE commit OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET RESULT_VARIABLE failed)
if(failed)
    set(commit unknown)
endif()
file(CONFIGURE OUTPUT ${OUT} @ONLY CONTENT "#pragma once

/// The commit that this program is made of; \"-dirty\" after it if files differ from the commit's.
#define PIERCE_COMMIT \"@commit@\"
")
