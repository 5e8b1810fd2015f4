// SPDX-License-Identifier: Apache-2.0
package org.doppel;

/** An error of the library. Its message is a sentence for a human. */
public final class DoppelException extends RuntimeException {
    /** The numbers of DplResult in doppel.h, which says what an app can do about each. */
    public static final int INVALID_ARGUMENT = -1;
    public static final int NOT_FOUND = -2;
    public static final int CORRUPT_DATA = -3;
    public static final int VERSION = -4;
    public static final int UNSUPPORTED = -5;
    public static final int OUT_OF_MEMORY = -6;
    public static final int IO = -7;
    public static final int DEVICE = -8;
    public static final int INTERNAL = -9;

    private static final long serialVersionUID = 1;

    private final int code;

    public DoppelException(int code, String message) {
        super(message);
        this.code = code;
    }

    public int getCode() {
        return code;
    }
}
