"""Whole plans made smooth: Gauss-Newton steps on accelerations and on how long each phase between contacts takes."""
