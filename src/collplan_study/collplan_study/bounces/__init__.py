"""The question of bounces: do deliberate ones pay?"""
